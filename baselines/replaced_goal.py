"""ICD that is told the goal of another scene: what it then does in spite of its goal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np

import icd_envs  # noqa: F401  registers the environments
from icd_agent.agent import ICDAgent
from icd_envs.api import Agent, Episode, FloatArray, Observation
from icd_envs.demonstrations import find_task


class ReplacedGoal:
    """An agent behind an observation whose goal, and the scene of it, are those of another episode.

    An agent that uses its goal succeeds as often as the two goals happen to ask for the same.
    """

    needs_simulator = True

    def __init__(self, agent: Agent, others: gym.Env[Any, Any]) -> None:
        """Put together.

        Args:
            agent: is given the other goals.
            others: its episodes give them; of the same object.
        """
        self._agent = agent
        self._others = others

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; the other goal follows from the seed."""
        self._agent.reset(replace(episode, foreign_goal=True), seed)
        other = int(np.random.default_rng([seed, 1]).integers(2**31))
        self._other: Observation = self._others.reset(seed=other)[0]

    def act(self, observation: Observation) -> FloatArray:
        """Plan one step towards the other goal."""
        other = self._other
        replaced: Any = {
            **observation,
            "desired_goal": other["desired_goal"],
            "goal_scene": other["goal_scene"],
        }
        return self._agent.act(replaced)


def make_replaced_goal(env_id: str) -> ReplacedGoal:
    """Build it with ``icd`` and goals of training scenes, contact goals where a task has them."""
    options: dict[str, Any] = {"goals": "contact"} if hasattr(find_task(env_id), "goals") else {}
    others = gym.make(env_id, split="train", disable_env_checker=True, **options)
    return ReplacedGoal(ICDAgent.from_pretrained(env_id), others)
