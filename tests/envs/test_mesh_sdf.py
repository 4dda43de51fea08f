from __future__ import annotations

import numpy as np
import pytest
import trimesh

from icd_envs.errors import InvalidOptionError
from icd_envs.geometry.mesh_sdf import MeshSolid
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box, rotation_z


def test_box_as_a_mesh_is_the_box() -> None:
    box = Box(np.array([0.1, -0.2, 0.05]), np.array([0.1, 0.03, 0.05]), rotation_z(0.7))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = box.rotation, box.center
    solid = MeshSolid(trimesh.creation.box(2 * box.half, transform=pose))
    points = box.center + np.random.default_rng(0).uniform(-0.12, 0.12, (300, 3))
    exact = BoxUnion([box])
    assert 5 < np.count_nonzero(exact(points) < 0) < 100
    np.testing.assert_allclose(solid(points), exact(points), atol=1e-9)
    np.testing.assert_allclose(solid.gradient(points), exact.gradient(points), atol=1e-6)


def test_sphere_is_what_it_should_be_everywhere() -> None:
    solid = MeshSolid(trimesh.creation.icosphere(subdivisions=4, radius=0.1))
    points = np.random.default_rng(1).normal(0, 0.1, (200, 3))
    radius = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(solid(points), radius - 0.1, atol=5e-4)
    far = np.abs(radius - 0.1) > 0.02
    along = (solid.gradient(points) * points / radius[:, None]).sum(axis=1)
    assert along[far].min() > 0.98


def test_points_on_the_surface_have_the_faces_normal() -> None:
    solid = MeshSolid(trimesh.creation.box((0.2, 0.2, 0.2)))
    np.testing.assert_allclose(solid.gradient(np.array([[0.1, 0.01, 0.02]])), [[1, 0, 0]])


def test_open_mesh_is_refused() -> None:
    mesh = trimesh.creation.box((1, 1, 1))
    mesh.update_faces(np.arange(len(mesh.faces)) > 1)
    with pytest.raises(InvalidOptionError, match="not closed"):
        MeshSolid(mesh)
