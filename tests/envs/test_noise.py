"""Noise on actions and observations: its size, its seed, and what it leaves alone."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from icd_envs.errors import EpisodeStateError, InvalidActionError, InvalidOptionError
from icd_envs.wrappers import NoisyActions, NoisyObservations
from tests.envs.making import digest, make, random_actions

STD = 0.01
ACTIONS = random_actions(3, 5)


def observed(env: gym.Env[Any, Any], seed: int = 4) -> list[dict[str, np.ndarray]]:
    first, _ = env.reset(seed=seed)
    return [first, *(env.step(action)[0] for action in ACTIONS)]


@pytest.mark.parametrize("wrapper", [NoisyActions, NoisyObservations])
def test_noise_depends_on_the_seed_alone(wrapper: type) -> None:
    env = wrapper(make(), STD)
    first = digest(observed(env))
    assert digest(observed(env, seed=5)) != first
    assert digest(observed(env)) == first == digest(observed(wrapper(make(), STD)))


@pytest.mark.parametrize("wrapper", [NoisyActions, NoisyObservations])
def test_unseeded_episodes_follow_from_the_last_seed(wrapper: type) -> None:
    env = wrapper(make(num_fixtures=1), STD)
    seen = []
    for seed in (4, None, None, 4, None, None):
        first, _ = env.reset(seed=seed)
        seen.append(digest([first, env.step(ACTIONS[0])[0]]))
    assert seen[:3] == seen[3:]
    assert len(set(seen)) == 3


@pytest.mark.parametrize("wrapper", [NoisyActions, NoisyObservations])
def test_step_before_reset_is_refused_as_without_noise(wrapper: type) -> None:
    with pytest.raises(EpisodeStateError, match="reset"):
        wrapper(make(), STD).step(ACTIONS[0])


@pytest.mark.parametrize("wrapper", [NoisyActions, NoisyObservations])
def test_no_noise_changes_no_bit(wrapper: type) -> None:
    assert digest(observed(wrapper(make(), 0.0))) == digest(observed(make()))


class Sent(gym.Wrapper[Any, Any, Any, Any]):
    """Remembers actions and does nothing."""

    def __init__(self) -> None:
        super().__init__(make())
        self.actions: list[np.ndarray] = []

    def step(self, action: np.ndarray) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.actions.append(action)
        return {}, 0.0, False, False, {}


def test_action_noise_has_the_size_asked_for() -> None:
    sent = Sent()
    env = NoisyActions(sent, 0.3)
    env.reset(seed=0)
    for _ in range(400):
        env.step(np.full(3, 0.5))
    assert np.std(sent.actions) == pytest.approx(0.3, rel=0.1)
    assert np.mean(sent.actions) == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("size", [1.5, 1e3, 1e300])
def test_no_action_is_large_enough_to_drown_the_noise(size: float) -> None:
    seen = []
    for action in (np.ones(3), np.full(3, size)):
        env = NoisyActions(make(num_fixtures=1), 0.3)
        env.reset(seed=4)
        steps = [env.step(sign * action) for sign in (1, -1, 1, -1)]
        seen.append(digest([step[0] for step in steps]))
        assert {step[4]["action_clipped"] for step in steps} == {action[0] > 1.0}
    assert seen[0] == seen[1]


@pytest.mark.parametrize("obs_mode", ["full", "partial"])
def test_observation_noise_is_on_the_present_state_only(obs_mode: str) -> None:
    noisy, clean = (
        observed(NoisyObservations(make(obs_mode=obs_mode), STD)),
        observed(make(obs_mode=obs_mode)),
    )
    for shown, true in zip(noisy, clean, strict=True):
        for name in ("desired_goal", "goal_scene"):
            np.testing.assert_array_equal(shown[name], true[name])
        np.testing.assert_array_equal(shown["observation"][3:], true["observation"][3:])
        assert (shown["observation"][:3] != true["observation"][:3]).all()
        for name in ("achieved_goal", "scene"):
            seen = true.get(f"{name}_mask", np.ones(len(true[name]))) > 0
            difference = shown[name] - true[name]
            assert np.std(difference[seen]) == pytest.approx(STD, rel=0.25)
            assert not shown[name][~seen].any()
            assert shown[name].dtype == np.float32


def test_garbage_is_refused_as_without_noise() -> None:
    env = NoisyActions(make(), STD)
    env.reset(seed=0)
    for action in (np.full(3, np.nan), 0.0, np.zeros(2), "left"):
        with pytest.raises(InvalidActionError):
            env.step(action)


@pytest.mark.parametrize("wrapper", [NoisyActions, NoisyObservations])
@pytest.mark.parametrize("std", [-1.0, float("nan"), "a", None])
def test_impossible_noise_is_refused(wrapper: type, std: float) -> None:
    with pytest.raises(InvalidOptionError, match="std must be"):
        wrapper(make(), std)
