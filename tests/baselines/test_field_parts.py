"""ICD whose chains are followed by a part of what it knows."""

from __future__ import annotations

import numpy as np
import pytest

from baselines.field_parts import REACH, PartOfField
from icd_agent.field.space import exact_features
from icd_agent.field.train import load_field
from icd_agent.weights import LOCAL_FIELD, shipped_folder
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.tasks.cable_routing import CableRouting
from tests.agent.field.small import small_field
from tests.envs.making import CABLE


@pytest.mark.parametrize("cut", [False, True])
def test_the_parts_of_a_field_add_up_to_it(cut: bool) -> None:
    field = small_field()
    rng = np.random.default_rng(0)
    scene, points = rng.uniform(0, 0.3, (200, 3)), rng.uniform(0, 0.6, (500, 3))
    near, far = (
        exact_features(PartOfField(field, part, cut=cut), scene)(points) for part in ("near", "far")
    )
    np.testing.assert_allclose(near + far, exact_features(field, scene)(points), atol=1e-6)
    in_one_only = (near == 0).all(-1) ^ (far == 0).all(-1)
    assert in_one_only.all() == cut


def test_a_part_that_is_cut_says_nothing_beyond_the_cut() -> None:
    field = load_field(shipped_folder(CABLE, LOCAL_FIELD))
    rng = np.random.default_rng(0)
    task = CableRouting()
    boxes = task.boxes(task.draw_scenes(rng).scene)
    cloud = sample_scene(boxes, 900, 100, rng)
    points = rng.uniform((0.0, -0.4, 0.0), (0.8, 0.4, 0.3), (5000, 3)).astype(np.float32)
    far = exact_features(PartOfField(field, "far", cut=True), cloud)(points)
    away = np.abs(BoxUnion(boxes)(points))
    close, distant = away < 0.5 * REACH, away > 1.5 * REACH
    assert close.sum() > 100
    assert distant.sum() > 100
    assert (far[close] == 0).all(-1).mean() > 0.98
    assert (far[distant] != 0).all(-1).mean() > 0.98


def test_near_to_surfaces_is_the_one_part_and_far_from_them_the_other() -> None:
    near, far = (
        PartOfField(load_field(shipped_folder(CABLE, LOCAL_FIELD)), p) for p in ("near", "far")
    )
    rng = np.random.default_rng(0)
    task = CableRouting()
    boxes = task.boxes(task.draw_scenes(rng).scene)
    cloud = sample_scene(boxes, 900, 100, rng)
    points = rng.uniform((0.0, -0.4, 0.0), (0.8, 0.4, 0.3), (5000, 3)).astype(np.float32)
    away = BoxUnion(boxes)(points)
    sizes = [np.linalg.norm(exact_features(each, cloud)(points), axis=-1) for each in (near, far)]
    share = sizes[0] / (sizes[0] + sizes[1])
    close, distant = np.abs(away) < 0.1 * REACH, away > 1.5 * REACH
    assert close.sum() > 20
    assert distant.sum() > 20
    assert share[close].mean() > 0.8
    assert share[distant].mean() < 0.05
