"""Places in a frame of the scene: distances of the world, and nothing of where it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from icd_agent.scene_points import ScenePoints
from icd_envs.api import FloatArray
from tests.agent.field.small import scene, small_field

RNG = np.random.default_rng(0)
CLOUDS = RNG.uniform((0.2, -0.2, 0.0), (0.6, 0.2, 0.2), (3, 20, 3)).astype(np.float32)


def observed(move: Any = lambda points: points, *, foreign: bool = False) -> Any:  # noqa: ANN401
    """A scene, the object in it and its goal, all moved; the goal may be of another scene."""
    here, there = scene(0).cloud, scene(1 if foreign else 0).cloud
    parts = {"scene": here, "goal_scene": there, "achieved_goal": CLOUDS[0]}
    parts["desired_goal"] = CLOUDS[1]
    return {name: move(points).astype(np.float32) for name, points in parts.items()}


def turned(points: FloatArray) -> FloatArray:
    turn = Rotation.from_euler("z", 1.1)
    return np.add(turn.apply(points.reshape(-1, 3)).reshape(points.shape), (0.4, -0.7, 0.0))


def test_distances_are_those_of_the_world_and_the_way_back_is_exact() -> None:
    placed = ScenePoints(small_field()).place(observed())
    there = placed.here(CLOUDS)
    apart = np.linalg.norm(np.diff(CLOUDS, axis=0), axis=-1)
    np.testing.assert_allclose(np.linalg.norm(np.diff(there, axis=0), axis=-1), apart, atol=1e-6)
    assert placed.back is not None
    np.testing.assert_allclose(placed.back(there), CLOUDS, atol=1e-6)


@pytest.mark.parametrize("foreign", [False, True])
def test_nothing_tells_where_in_the_world_a_scene_is(foreign: bool) -> None:
    space = ScenePoints(small_field())
    before = space.place(observed(foreign=foreign), foreign=foreign)
    after = space.place(observed(turned, foreign=foreign), foreign=foreign)
    np.testing.assert_allclose(after.here(turned(CLOUDS)), before.here(CLOUDS), atol=2e-3)
    np.testing.assert_allclose(after.goal(turned(CLOUDS)), before.goal(CLOUDS), atol=2e-3)


def test_a_foreign_goal_is_where_it_lies_or_where_it_is_in_its_scene() -> None:
    observation = observed(foreign=True)
    in_place = ScenePoints(small_field(), "in place").place(observation, foreign=True)
    np.testing.assert_array_equal(in_place.goal(CLOUDS), in_place.here(CLOUDS))
    in_its_scene = ScenePoints(small_field()).place(observation, foreign=True)
    own = ScenePoints(small_field()).place({**observation, "scene": observation["goal_scene"]})
    np.testing.assert_array_equal(in_its_scene.goal(CLOUDS), own.here(CLOUDS))
    assert np.abs(in_its_scene.goal(CLOUDS) - in_place.goal(CLOUDS)).max() > 0.02


def test_points_that_were_not_seen_do_not_count() -> None:
    observation = observed()
    seen = np.arange(len(observation["scene"])) % 2 == 0
    blank = np.where(seen[:, None], observation["scene"], np.float32(0.0))
    partial = {**observation, "scene": blank, "scene_mask": seen.astype(np.float32)}
    only = {**observation, "scene": observation["scene"][seen]}
    space = ScenePoints(small_field(), "in place")
    np.testing.assert_array_equal(
        space.place(partial).here(CLOUDS),
        space.place(only).here(CLOUDS),
    )
