"""What is floor is decided once, by the margin of the field; a bare floor is all of its scene."""

from __future__ import annotations

import numpy as np

from icd_agent.field.config import FieldConfig
from icd_agent.field.data import FieldData, FieldScene
from icd_agent.field.supervision import NEAR, above_floor, draw_queries
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box
from tests.agent.field.small import scene

LOW = 0.02
"""[m] height of the only fixture."""


def low_scene() -> FieldScene:
    """A floor at z = 1 m and a plate just above it."""
    rng = np.random.default_rng(0)
    flat = rng.uniform(-0.2, 0.2, (100, 3))
    flat[:, 2] = 1.0
    plate = rng.uniform(-0.05, 0.05, (100, 3))
    plate[:, 2] = 1.0 + LOW
    box = Box(np.array([0.0, 0.0, 1.0 + LOW / 2]), np.array([0.05, 0.05, LOW / 2]), np.eye(3))
    cloud = np.concatenate([flat, plate]).astype(np.float32)
    return FieldScene(cloud, cloud[:5], BoxUnion([box]))


def near(margin: float) -> np.ndarray:
    """Queries near surfaces."""
    found = low_scene()
    rng = np.random.default_rng(1)
    queries = draw_queries(found.cloud, found.object_points, 400, rng, floor_margin=margin)
    return queries[: int(NEAR * 400)]


def test_points_above_the_margin_are_of_fixtures() -> None:
    cloud = low_scene().cloud
    assert np.array_equal(above_floor(cloud, LOW / 2), cloud[100:])
    assert np.array_equal(above_floor(cloud), cloud[100:])


def test_a_scene_of_bare_floor_is_all_there_is_to_ask_about() -> None:
    cloud = low_scene().cloud
    assert np.array_equal(above_floor(cloud, 2 * LOW), cloud)
    assert np.abs(near(margin=LOW / 2)[:, :2]).max() < 0.15  # around the plate
    assert np.abs(near(margin=2 * LOW)[:, :2]).max() > 0.15  # and around everything


def test_the_margin_of_the_field_is_that_of_its_data() -> None:
    def drawn(margin: float) -> np.ndarray:
        data = FieldData([low_scene()], floor_margin=margin)
        _, truth, _ = data.draw(1, 40, np.random.default_rng(2))
        return truth.points.numpy()

    assert np.array_equal(drawn(FieldConfig.floor_margin), drawn(LOW / 2))
    assert not np.array_equal(drawn(LOW / 2), drawn(2 * LOW))


def test_queries_by_default_are_those_of_the_default_field() -> None:
    found = scene(0)
    drawn = [
        draw_queries(found.cloud, found.object_points, 50, np.random.default_rng(3), **margin)
        for margin in ({}, {"floor_margin": FieldConfig.floor_margin})
    ]
    assert np.array_equal(*drawn)
