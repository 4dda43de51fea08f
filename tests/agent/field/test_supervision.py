from __future__ import annotations

import numpy as np
import trimesh

from icd_agent.field.supervision import NEAR, ON_OBJECT, draw_queries, supervise
from icd_envs.geometry.mesh_sdf import MeshSolid
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box
from icd_envs.tasks.cable_routing import CableRouting

COUNT = 2000


def test_queries_are_near_surfaces_on_the_object_and_around() -> None:
    rng = np.random.default_rng(0)
    task = CableRouting()
    boxes = task.boxes(task.draw_scenes(rng).scene)
    scene = sample_scene(boxes, 1000, 200, rng)
    place = np.full((5, 3), 9.0)
    points = draw_queries(scene, place, COUNT, rng)
    targets = supervise(points, BoxUnion(boxes))
    near, there = int(NEAR * COUNT), int((NEAR + ON_OBJECT) * COUNT)
    assert np.mean(np.abs(targets.distance[:near]) < 0.03) > 0.8
    assert np.abs(points[near:there] - 9.0).max() < 0.1
    assert np.abs(points[there:]).max() < 2.0
    assert np.all(points[there:, 2] >= scene[:, 2].min())
    # Thin walls: enough of what is near must be inside to learn from.
    assert 0.1 < np.mean(targets.distance[:near] < 0) < 0.7
    assert points.dtype == targets.distance.dtype == targets.gradient.dtype == np.float32


def test_any_mesh_teaches_what_the_same_boxes_do() -> None:
    box = Box(np.zeros(3), np.array([0.1, 0.05, 0.02]), np.eye(3))
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.15, 0.15, (200, 3)).astype(np.float32)
    exact = supervise(points, BoxUnion([box]))
    meshed = supervise(points, MeshSolid(trimesh.creation.box(2 * box.half)))
    np.testing.assert_allclose(meshed.distance, exact.distance, atol=1e-6)
    np.testing.assert_allclose(meshed.gradient, exact.gradient, atol=1e-4)
