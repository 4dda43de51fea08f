"""Copies of every environment, and the simulators that one environment hands out."""

from __future__ import annotations

import contextlib
import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from icd_envs.errors import EpisodeStateError, RenderingUnavailableError
from icd_envs.tasks.env import ContactEnv
from icd_envs.wrappers import MismatchedPlanner
from tests.envs.making import bare, digest, play, random_actions, remake

COPIES: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
}


@pytest.mark.parametrize("kind", COPIES)
def test_copy_goes_on_bit_for_bit_and_alone(env: ContactEnv[Any], kind: str) -> None:
    made = remake(env, render_mode="rgb_array", width=32, height=24)
    made.reset(seed=5)
    play(bare(made), random_actions(0, 5))
    original = bare(made)
    simulator = original.episode(simulator=True, threads=2).simulator
    assert simulator is not None
    with contextlib.suppress(RenderingUnavailableError):
        made.render()
    other = COPIES[kind](made)
    assert other.spec == made.spec
    state, actions = original.snapshot(), random_actions(1, 4)
    expected = digest(play(original, actions))
    assert digest(play(bare(other), actions)) == expected
    believed = bare(other).episode(simulator=True, threads=2).simulator
    assert believed is not None
    rollouts = [
        each.rollout(state, actions[None]).points.tobytes() for each in (simulator, believed)
    ]
    assert rollouts[0] == rollouts[1]
    made.close()
    assert other.reset()[0]["achieved_goal"].shape == (200, 3)
    other.close()


def test_simulators_of_an_episode_share_threads(env: ContactEnv[Any]) -> None:
    env.reset(seed=0)
    handed = [env.episode(simulator=True, threads=n).simulator for n in (1, 2, 1, 2, 2)]
    assert len({id(each) for each in handed}) == 5
    threads = {id(each._threads) for each in handed}  # type: ignore[union-attr]
    assert len(threads) == 2
    state = env.snapshot()
    env.reset(seed=0)
    for each in handed:
        assert each is not None
        with pytest.raises(EpisodeStateError, match="for a new one"):
            each.rollout(state, np.zeros((1, 1, 3)))


def test_wrong_model_of_one_simulator_is_not_that_of_another(env: ContactEnv[Any]) -> None:
    env.reset(seed=0)
    state, actions = env.snapshot(), random_actions(2, 4, 6)
    wrapped = MismatchedPlanner(env, stiffness=2.0, mass=0.7, friction=0.5)
    before = env.episode(simulator=True, threads=2).simulator
    assert before is not None
    expected = before.rollout(state, actions).points.tobytes()
    for _ in range(2):
        wrong = wrapped.episode(simulator=True, threads=2).simulator
        after = env.episode(simulator=True, threads=2).simulator
        assert wrong is not None
        assert after is not None
        believed = wrong.rollout(state, actions).points.tobytes()
        assert believed != expected
        for true in (before, after):
            assert true.rollout(state, actions).points.tobytes() == expected
        assert wrong.rollout(state, actions).points.tobytes() == believed
