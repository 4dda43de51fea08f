from __future__ import annotations

import numpy as np
import pytest

from icd_agent.field.baked import BakeConfig
from icd_agent.field.space import ExactFieldSpace, FieldSpace, exact_features
from icd_agent.field.train import load_field
from icd_agent.weights import LOCAL_FIELD, TRAINED_FOR, shipped_folder
from icd_envs import ENV_IDS
from icd_envs.api import Observation
from icd_envs.errors import CheckpointError
from tests.agent.field.small import scene, small_field
from tests.agent.toy_world import ToyWorld

COARSE = BakeConfig(fine=0.02, coarse=0.08)


def observed(present: int, goal: int) -> Observation:
    observation = ToyWorld().observation()
    observation["scene"] = scene(present).cloud
    observation["goal_scene"] = scene(goal).cloud
    return observation


def test_states_are_compared_in_the_scene_they_belong_to() -> None:
    field = load_field(shipped_folder("ICDCableRouting-v0", LOCAL_FIELD))
    placed = FieldSpace(field).place(observed(0, 1), foreign=True)
    points = scene(0).object_points[None]
    there = exact_features(field, scene(1).cloud)(points)
    assert placed.goal(points).shape == (1, 20, field.config.descriptor)
    np.testing.assert_array_equal(placed.goal(points), there)
    here = exact_features(field, scene(0).cloud)(points)
    assert np.abs(placed.here(points) - here).mean() < 0.2 * np.abs(here - there).mean()


def test_a_goal_of_the_same_scene_is_measured_in_the_same_way() -> None:
    placed = FieldSpace(small_field(), COARSE).place(observed(0, 0))
    assert placed.goal is placed.here


def test_a_goal_is_of_another_scene_if_the_episode_says_so_however_the_scene_is_seen() -> None:
    points, blurred = scene(0).object_points, observed(0, 0)
    blurred["scene"] = blurred["scene"] + np.float32(1e-3)
    for space in (FieldSpace(small_field(), COARSE), ExactFieldSpace(small_field())):
        own, foreign = space.place(blurred), space.place(blurred, foreign=True)
        np.testing.assert_array_equal(own.goal(points), own.here(points))
        exact = exact_features(small_field(), blurred["goal_scene"])(points)
        np.testing.assert_array_equal(foreign.goal(points), exact)


def test_points_that_are_not_seen_play_no_part() -> None:
    field, whole = small_field(), observed(0, 1)
    seen = np.arange(300) % 3 > 0
    partial = dict(whole)
    partial["scene"] = np.where(seen[:, None], whole["scene"], 0.0).astype(np.float32)
    partial["scene_mask"] = seen.astype(np.float32)
    points = scene(0).object_points
    found = FieldSpace(field, COARSE).place(partial).here(points)  # type: ignore[arg-type]
    only_seen = dict(whole)
    only_seen["scene"] = whole["scene"][seen]
    expected = FieldSpace(field, COARSE).place(only_seen).here(points)  # type: ignore[arg-type]
    np.testing.assert_array_equal(found, expected)


def test_exact_features_do_not_depend_on_how_many_are_asked_for() -> None:
    features = exact_features(small_field(), scene(0).cloud)
    points = np.random.default_rng(0).uniform(0, 0.3, (3, 4000, 3))
    together = features(points)
    assert together.shape == (3, 4000, 8)
    assert together.dtype == np.float32
    np.testing.assert_allclose(features(points[1, :50]), together[1, :50], atol=1e-6)


def test_every_environment_has_weights() -> None:
    assert set(TRAINED_FOR) == set(ENV_IDS)
    for env_id in ENV_IDS:
        field = FieldSpace.shipped(f"icd_envs:{env_id}")
        assert isinstance(field, FieldSpace)
        weights = shipped_folder(env_id, LOCAL_FIELD) / "model.safetensors"
        assert weights.stat().st_size <= 8e6


def test_an_environment_without_weights_is_named() -> None:
    with pytest.raises(CheckpointError, match="did you mean 'ICDCableRouting-v0'"):
        shipped_folder("ICDCableRouting-v1", "field")
