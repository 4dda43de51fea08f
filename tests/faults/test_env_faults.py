"""What callers and physics do wrong, and what the environments make of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

from icd_envs.errors import (
    EpisodeStateError,
    IcdError,
    IncompatibleStateError,
    InvalidActionError,
    InvalidOptionError,
    InvalidSeedError,
)
from icd_envs.tasks.checks import check_seed
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import digest, play, random_actions, remake, state_bits

UNUSABLE = {
    "nan": np.array([0.0, np.nan, 0.0]),
    "inf": np.array([np.inf, 0.0, 0.0]),
    "minus inf": [0.0, 0.0, -np.inf],
    "two": np.zeros(2),
    "four": np.zeros(4),
    "batch": np.zeros((1, 3)),
    "scalar": 0.5,
    "empty": [],
    "ragged": [[0.0], [0.0, 1.0], 0.0],
    "none": None,
    "text": "left",
    "texts": ["0", "0", "0"],
    "objects": np.array([0.0, 0.0, None], dtype=object),
    "complex": np.zeros(3, dtype=complex),
    "booleans": np.ones(3, dtype=bool),
    "mapping": {"x": 0.0, "y": 0.0, "z": 0.0},
    "huge integer": [10**400, 0, 0],
    "on another device": torch.zeros(3, device="meta"),
    "with gradient": torch.zeros(3, requires_grad=True),
}

EQUAL = {
    "list": lambda a: a.tolist(),
    "tuple": lambda a: tuple(a.tolist()),
    "float64": lambda a: a.astype(np.float64),
    "tensor": torch.from_numpy,
    "strided": lambda a: np.repeat(a, 2)[::2],
    "read-only": lambda a: np.frombuffer(a.tobytes(), np.float32),
}


@pytest.fixture
def fresh(env: ContactEnv[Any]) -> Iterator[gym.Env[Any, Any]]:
    """As most users have it: wrapped, and not yet reset."""
    made = remake(env)
    yield made
    made.close()


@pytest.mark.parametrize("name", UNUSABLE)
def test_unusable_action_is_refused_and_nothing_changes(env: ContactEnv[Any], name: str) -> None:
    state = env.snapshot()
    with pytest.raises(InvalidActionError, match=r"action .*send 3 finite numbers"):
        env.step(UNUSABLE[name])  # type: ignore[arg-type]
    assert state_bits(env) == state.physics.tobytes()
    after = play(env, random_actions(0, 5))
    env.restore(state)
    assert digest(play(env, random_actions(0, 5))) == digest(after)
    env.restore(state)


@pytest.mark.parametrize("size", [1e9, 1.0001, 2, np.float64(1e300)])
def test_action_beyond_the_box_is_clipped_and_reported(env: ContactEnv[Any], size: float) -> None:
    state = env.snapshot()
    observation, *_, info = env.step(np.array([size, 0.5, -size]))
    assert info["action_clipped"] is True
    env.restore(state)
    expected, *_, info = env.step(np.array([1.0, 0.5, -1.0]))
    assert info["action_clipped"] is False
    assert digest([observation]) == digest([expected])
    env.restore(state)


@pytest.mark.parametrize("kind", EQUAL)
def test_other_forms_of_an_action_do_the_same(env: ContactEnv[Any], kind: str) -> None:
    state, actions = env.snapshot(), random_actions(1, 3)
    expected = digest(play(env, actions))
    env.restore(state)
    assert digest([env.step(EQUAL[kind](action))[0] for action in actions]) == expected
    env.restore(state)


CALLS: dict[str, Callable[[Any], Any]] = {
    "step": lambda env: env.step(np.zeros(3)),
    "render": lambda env: env.render(),
    "episode": lambda env: env.unwrapped.episode(),
    "snapshot": lambda env: env.unwrapped.snapshot(),
}


@pytest.mark.parametrize("call", CALLS)
def test_calls_out_of_order_are_answered_with_the_fix(fresh: gym.Env[Any, Any], call: str) -> None:
    for env in (fresh, fresh.unwrapped):
        with pytest.raises(EpisodeStateError, match=r"reset\(seed=\.\.\.\)"):
            CALLS[call](env)
    fresh.close()
    fresh.close()
    for env in (fresh, fresh.unwrapped):
        with pytest.raises(EpisodeStateError, match="make a new environment"):
            CALLS[call](env)
        with pytest.raises(EpisodeStateError, match="make a new environment"):
            env.reset(seed=0)


def test_refused_first_steps_leave_a_wrapped_environment_usable(fresh: gym.Env[Any, Any]) -> None:
    with pytest.raises(EpisodeStateError):
        fresh.step(np.zeros(3))
    observation, _ = fresh.reset(seed=0)
    assert fresh.observation_space.contains(observation)
    with pytest.raises(InvalidActionError):
        fresh.step(np.full(3, np.nan))
    assert fresh.observation_space.contains(fresh.step(np.zeros(3, np.float32))[0])


@pytest.mark.parametrize("seed", [-1, 2**64, 2**70, "a", 1.5, True, np.float64(3), [1], "7"])
def test_bad_seed_is_refused_and_the_episode_goes_on(env: ContactEnv[Any], seed: object) -> None:
    before = state_bits(env)
    with pytest.raises(InvalidSeedError, match="seed=0"):
        env.reset(seed=seed)
    assert state_bits(env) == before
    env.step(np.zeros(3, np.float32))


def test_every_kind_of_integer_is_a_seed(env: ContactEnv[Any]) -> None:
    expected = digest([env.reset(seed=3)[0]])
    assert digest([env.reset(seed=np.int64(3))[0]]) == expected
    assert env.observation_space.contains(env.reset(seed=2**64 - 1)[0])
    assert [check_seed(kind(3)) for kind in (np.uint8, np.int32, np.uint64)] == [3, 3, 3]


def test_unknown_reset_option_is_named_and_empty_ones_pass(env: ContactEnv[Any]) -> None:
    with pytest.raises(InvalidOptionError, match="'num_clips'"):
        env.reset(seed=0, options={"num_clips": 3})
    assert env.observation_space.contains(env.reset(seed=0, options={})[0])


@pytest.mark.parametrize("options", [5, "num_clips", ["num_clips"]])
def test_reset_options_that_are_no_dictionary_are_refused(
    env: ContactEnv[Any], options: object
) -> None:
    before = state_bits(env)
    with pytest.raises(InvalidOptionError, match="must be a dictionary"):
        env.reset(seed=0, options=options)  # type: ignore[arg-type]
    assert state_bits(env) == before


@pytest.mark.parametrize("state", [None, 5, np.zeros(3)])
def test_what_is_no_snapshot_is_refused(env: ContactEnv[Any], state: object) -> None:
    simulator = env.episode(simulator=True).simulator
    assert simulator is not None
    before = state_bits(env)
    with pytest.raises(IncompatibleStateError, match=r"snapshot\(\)"):
        env.restore(state)  # type: ignore[arg-type]
    with pytest.raises(IncompatibleStateError, match=r"snapshot\(\)"):
        simulator.rollout(state, np.zeros((1, 1, 3)))  # type: ignore[arg-type]
    assert state_bits(env) == before


def test_there_is_no_model_or_goal_without_a_scene(fresh: gym.Env[Any, Any]) -> None:
    inner = fresh.unwrapped
    for name in ("model", "data", "goal"):
        assert not hasattr(inner, name)
        with pytest.raises(EpisodeStateError, match=r"reset\(seed=\.\.\.\)"):
            getattr(inner, name)
    fresh.reset(seed=0)
    assert hasattr(inner, "model")
    assert hasattr(inner, "data")
    assert hasattr(inner, "goal")
    fresh.close()
    assert not hasattr(inner, "model")


def test_every_error_is_one_of_ours_and_of_a_builtin_kind() -> None:
    kinds = IcdError.__subclasses__()
    assert len(kinds) >= 7
    assert all(issubclass(kind, (ValueError, RuntimeError)) for kind in kinds)
