from __future__ import annotations

import numpy as np
import pytest

from icd_envs.api import Float64Array
from icd_envs.geometry.point_cloud import FLOOR_MARGIN, sample_scene
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box, rotation_z
from icd_envs.scenes.clip import Clip

COUNT, FLOOR = 1000, 200
CLIPS = [box for clip in (Clip((0.3, 0.1), 1.2), Clip((0.5, -0.2), -2.0)) for box in clip.boxes()]


def cube(x: float, size: float) -> Box:
    """A cube standing on the floor."""
    return Box(np.array([x, 0.0, size / 2]), np.full(3, size / 2), np.eye(3))


def sample(boxes: list[Box], seed: int = 0) -> Float64Array:
    cloud = sample_scene(boxes, COUNT, FLOOR, np.random.default_rng(seed))
    assert cloud.shape == (COUNT, 3)
    assert cloud.dtype == np.float32
    return cloud.astype(np.float64)


@pytest.mark.parametrize("seed", range(3))
def test_fixture_points_lie_on_exposed_surfaces(seed: int) -> None:
    surface = sample(CLIPS, seed)[: COUNT - FLOOR]
    assert np.abs(BoxUnion(CLIPS)(surface)).max() < 2e-6
    assert surface[:, 2].min() > 0


@pytest.mark.parametrize("seed", range(3))
def test_floor_points_lie_on_the_free_floor_around_the_fixtures(seed: int) -> None:
    cloud = sample(CLIPS, seed)
    surface, floor = cloud[: COUNT - FLOOR, :2], cloud[COUNT - FLOOR :]
    np.testing.assert_array_equal(floor[:, 2], 0.0)
    assert BoxUnion(CLIPS)(floor).min() > 0
    assert np.all(floor[:, :2] > surface.min(axis=0) - FLOOR_MARGIN - 1e-6)
    assert np.all(floor[:, :2] < surface.max(axis=0) + FLOOR_MARGIN + 1e-6)


def test_points_are_spread_by_area() -> None:
    small, large = cube(0.0, 0.1), cube(1.0, 0.2)
    surface = sample([small, large])[: COUNT - FLOOR]
    # Visible: four sides and the top; 1 to 4 in area, +- 4 standard deviations.
    assert np.mean(surface[:, 0] < 0.5) == pytest.approx(0.2, abs=0.06)
    sides = np.isclose(surface[:, 2], 0.1) & (surface[:, 0] < 0.5)
    assert np.sum(sides) / np.sum(surface[:, 0] < 0.5) == pytest.approx(0.2, abs=0.13)


def test_faces_between_touching_boxes_are_hidden() -> None:
    left, right = cube(0.0, 0.1), cube(0.09, 0.1)  # they overlap from x = 0.04 to 0.05
    surface = sample([left, right])[: COUNT - FLOOR]
    deep = (np.abs(surface[:, 1]) < 0.049) & (surface[:, 2] < 0.099)
    assert np.all(np.abs(surface[deep, 0] - 0.045) > 0.09)


def test_same_generator_state_gives_the_same_cloud_and_another_does_not() -> None:
    np.testing.assert_array_equal(sample(CLIPS, 3), sample(CLIPS, 3))
    assert not np.array_equal(sample(CLIPS, 3), sample(CLIPS, 4))


def test_turned_fixtures_give_a_cloud_on_the_turned_surfaces() -> None:
    rotation, shift = rotation_z(0.8), np.array([0.2, -0.1, 0.0])
    turned = [box.moved(rotation, shift) for box in CLIPS]
    surface = sample(turned)[: COUNT - FLOOR]
    back = (surface - shift) @ rotation
    assert np.abs(BoxUnion(CLIPS)(back)).max() < 2e-6
