"""The rung that replaces the goal by another scene's."""

from __future__ import annotations

import gymnasium as gym
import numpy as np

from baselines.replaced_goal import ReplacedGoal
from icd_envs.api import Episode, Float32Array, Observation
from tests.envs.making import CABLE


class Listener:
    """Keeps what it is told and stands still."""

    needs_simulator = False
    needs_oracle = False

    def __init__(self) -> None:
        self.told: list[Observation] = []
        self.foreign: list[bool] = []

    def reset(self, episode: Episode, seed: int) -> None:
        self.foreign.append(episode.foreign_goal)

    def act(self, observation: Observation) -> Float32Array:
        self.told.append(observation)
        return np.zeros(3, np.float32)


def test_agent_is_told_another_goal_that_follows_from_the_seed() -> None:
    env = gym.make(CABLE)
    observation, _ = env.reset(seed=0)
    before = {name: value.copy() for name, value in observation.items()}
    listener = Listener()
    agent = ReplacedGoal(listener, gym.make(CABLE, split="train", goals="contact"))
    for seed in (1, 2, 1):
        agent.reset(env.unwrapped.episode(), seed)  # type: ignore[attr-defined]
        agent.act(observation)
    first, second, again = listener.told
    assert listener.foreign == [True] * 3
    for name in ("desired_goal", "goal_scene"):
        assert not np.array_equal(first[name], observation[name])  # type: ignore[literal-required]
        assert not np.array_equal(first[name], second[name])  # type: ignore[literal-required]
        np.testing.assert_array_equal(first[name], again[name])  # type: ignore[literal-required]
    for name in ("observation", "achieved_goal", "scene"):
        np.testing.assert_array_equal(first[name], observation[name])  # type: ignore[literal-required]
    for name, value in before.items():
        np.testing.assert_array_equal(observation[name], value)
