"""Hidden points of the object are guessed from seen ones; full observations are left alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from icd_agent.completion import Completion, seen_scene
from icd_envs.api import Observation
from icd_envs.errors import InvalidObservationError
from tests.envs.making import make

STRAIGHT = np.linspace((-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 101).astype(np.float32)
BENT = np.stack([0.4 * np.sin(2 * STRAIGHT[:, 0]), STRAIGHT[:, 0] ** 2, 0 * STRAIGHT[:, 0]], axis=1)


def observed(cloud: np.ndarray, seen: np.ndarray | None) -> Observation:
    whole: dict[str, Any] = {"observation": np.full(6, 0.2, np.float32), "achieved_goal": cloud}
    if seen is not None:
        whole["achieved_goal"] = np.where(seen[:, None], cloud, 0.0).astype(np.float32)
        whole["achieved_goal_mask"] = seen.astype(np.float32)
    return whole  # type: ignore[return-value]


def test_full_observations_are_returned_as_they_are() -> None:
    full = observed(BENT, None)
    assert Completion(STRAIGHT)(full) is full


def test_a_hidden_stretch_lies_between_its_ends() -> None:
    seen = np.ones(101, bool)
    seen[40:60] = False
    partial = observed(BENT, seen)
    before = partial["achieved_goal"].copy()
    found = Completion(STRAIGHT)(partial)["achieved_goal"]
    assert (found.shape, found.dtype) == ((101, 3), np.float32)
    np.testing.assert_allclose(found, BENT, atol=0.025)
    np.testing.assert_array_equal(partial["achieved_goal"], before)


def test_noise_of_seen_points_is_evened_out() -> None:
    noisy = BENT + np.random.default_rng(0).normal(0.0, 0.002, BENT.shape)
    found = Completion(STRAIGHT)(observed(noisy, np.ones(101, bool)))["achieved_goal"]
    error, noise = (np.linalg.norm(x - BENT, axis=1).mean() for x in (found, noisy))
    assert error < 0.75 * noise


def test_if_nothing_is_seen_the_last_guess_stays_and_before_it_the_hand_is_known() -> None:
    nothing, everything = np.zeros(101, bool), np.ones(101, bool)
    complete = Completion(STRAIGHT)
    first = complete(observed(BENT, nothing))["achieved_goal"]
    np.testing.assert_allclose(first, STRAIGHT + np.float32(0.2), atol=1e-6)
    known = complete(observed(BENT, everything))["achieved_goal"]
    np.testing.assert_array_equal(complete(observed(BENT, nothing))["achieved_goal"], known)


def test_of_a_single_point_that_moved_the_rest_moves_along_and_keeps_its_shape() -> None:
    complete, one = Completion(STRAIGHT), np.zeros(101, bool)
    one[70] = True
    before = complete(observed(BENT, np.ones(101, bool)))["achieved_goal"]
    step = np.float32((0.01, 0.0, 0.02))
    after = complete(observed(BENT + step, one))["achieved_goal"]
    np.testing.assert_allclose(after, before + step, atol=1e-3)


def test_a_scene_of_which_nothing_is_seen_is_refused() -> None:
    scene = {"scene": BENT, "scene_mask": np.zeros(101)}
    with pytest.raises(InvalidObservationError, match="scene_mask is 0 everywhere"):
        seen_scene(scene)  # type: ignore[arg-type]
    scene["scene_mask"][7] = 1.0
    np.testing.assert_array_equal(seen_scene(scene), BENT[[7]])  # type: ignore[arg-type]


@pytest.mark.parametrize("env_id", ["ICDCableRouting-v0", "ICDNotebookFolding-v0"])
def test_guesses_are_closer_than_what_is_observed(env_id: str) -> None:
    env, full = make(env_id, obs_mode="partial"), make(env_id)
    partial, _ = env.reset(seed=4)
    truth, _ = full.reset(seed=4)
    complete = Completion(env.episode().canonical_cloud)
    hidden, errors = [], []
    for _ in range(40):
        found = complete(partial)["achieved_goal"]
        errors.append(np.linalg.norm(found - truth["achieved_goal"], axis=1))
        hidden.append(partial["achieved_goal_mask"] == 0)  # type: ignore[typeddict-item]
        action = np.array([0.7, -0.2, -0.3], np.float32)
        partial, truth = env.step(action)[0], full.step(action)[0]
    unseen, error = np.array(hidden), np.array(errors)
    assert 0 < unseen.mean() < 0.7
    assert error[unseen].mean() < 0.06
    assert error[~unseen].mean() < 0.0035
