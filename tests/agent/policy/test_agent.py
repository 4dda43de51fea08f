"""The agent of action-chunk policies: when it generates, what it remembers, what it keeps."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

from icd_agent.checkpoints import save_checkpoint
from icd_agent.policy.agent import ChunkAgent
from icd_agent.policy.encoders import Seen
from icd_agent.policy.policy import ChunkPolicy
from icd_agent.training.initial import initialise
from icd_envs.api import Agent, Float32Array
from icd_envs.errors import CheckpointError, EpisodeStateError
from tests.agent.field.small import small_field
from tests.agent.policy.test_policy import KEY_POINTS, POINTS
from tests.envs.making import CABLE

LIMITS = -torch.ones(3), torch.ones(3)


def agent(sees: str = "points") -> ChunkAgent:
    field = small_field() if sees == "key points" else None
    policy = ChunkPolicy(POINTS if field is None else KEY_POINTS, LIMITS).eval()
    initialise(policy, torch.Generator().manual_seed(0))
    return ChunkAgent(policy, field)


@pytest.fixture
def env() -> Iterator[gym.Env[Any, Any]]:
    env = gym.make(CABLE)
    yield env
    env.close()


def actions(agent: ChunkAgent, env: gym.Env[Any, Any], steps: int = 6) -> np.ndarray:
    observation, _ = env.reset(seed=3)
    unwrapped: Any = env.unwrapped
    agent.reset(unwrapped.episode(), seed=1)
    found = []
    for _ in range(steps):
        found.append(agent.act(observation))
        observation = env.step(found[-1])[0]
    return np.array(found)


class Counting(ChunkPolicy):
    """Remembers what it was shown; its actions are numbered."""

    def __init__(self) -> None:
        super().__init__(POINTS, LIMITS)
        self.shown: list[Seen] = []

    def sample(self, seen: Seen, rng: np.random.Generator) -> Float32Array:
        self.shown.append(seen)
        numbers = 100 * len(self.shown) + np.arange(POINTS.horizon)
        return (np.ones((1, POINTS.horizon, 3)) * numbers[:, None] / 1000).astype(np.float32)


def test_it_executes_from_the_present_on_and_then_generates_again(env: gym.Env[Any, Any]) -> None:
    policy = Counting()
    found = actions(ChunkAgent(policy), env, 9)
    # Eight actions from the one for the older observation; the second is for the present one.
    numbers = np.rint(1000 * found[:, 0]).astype(int)
    np.testing.assert_array_equal(numbers, [101, 102, 103, 104, 201, 202, 203, 204, 301])
    first, second, _ = policy.shown
    assert torch.equal(first.gripper[0, 0], first.gripper[0, 1])
    assert not torch.equal(second.gripper[0, 0], second.gripper[0, 1])
    assert torch.equal(first.scene, second.scene)
    assert torch.equal(first.goal, second.goal)


def test_it_shows_what_it_is_about_to_do(env: gym.Env[Any, Any]) -> None:
    acting = ChunkAgent(Counting())
    assert acting.plan_view() is None
    actions(acting, env, 3)
    view = acting.plan_view()
    assert view is not None
    assert view.actions is not None
    np.testing.assert_allclose(view.actions[:, 0], [0.103, 0.104], atol=1e-6)


@pytest.mark.parametrize("sees", ["points", "key points"])
def test_saved_and_read_back_it_acts_the_same_to_the_bit(
    env: gym.Env[Any, Any], tmp_path: Path, sees: str
) -> None:
    first = agent(sees)
    assert isinstance(first, Agent)
    assert not first.needs_simulator
    before = actions(first, env)
    assert np.abs(before).max() <= 1
    np.testing.assert_array_equal(actions(first, env), before)
    first.save_pretrained(tmp_path)
    np.testing.assert_array_equal(actions(ChunkAgent.from_pretrained(tmp_path), env), before)


def test_a_policy_whose_field_was_replaced_is_refused(tmp_path: Path) -> None:
    agent("key points").save_pretrained(tmp_path)
    other = small_field(1)
    save_checkpoint(tmp_path / "field", "field", other, other.config, {})
    with pytest.raises(CheckpointError, match="was trained with the field"):
        ChunkAgent.from_pretrained(tmp_path)


def test_episodes_begin_with_reset(env: gym.Env[Any, Any]) -> None:
    with pytest.raises(EpisodeStateError, match="reset"):
        agent().act(env.reset(seed=3)[0])


def test_missing_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=str(tmp_path)):
        ChunkAgent.from_pretrained(tmp_path)
