"""How an episode begins for an agent, whichever command plays it."""

from __future__ import annotations

from typing import Any

import gymnasium as gym

from benchmarks.generators import seed_global_generators
from icd_envs.api import Agent, Episode


def privileges(agent: Agent) -> dict[str, bool]:
    """Which parts of an episode the agent asks for, beside what it observes."""
    parts = ("simulator", "oracle")
    return {part: bool(getattr(agent, f"needs_{part}", False)) for part in parts}


def episode_for(env: gym.Env[Any, Any], agent: Agent, threads: int = 1) -> Episode:
    """The episode that an environment of this project has just begun, as the agent asks for it.

    Args:
        env: after ``reset``; wrapped or not.
        agent: who will act in it.
        threads: of the simulator that planners are given.
    """
    episode: Episode = env.get_wrapper_attr("episode")(**privileges(agent), threads=threads)
    return episode


def begin(agent: Agent, episode: Episode, seed: int) -> None:
    """Reset the agent, and before it the generators that are nobody's, which it may draw from."""
    seed_global_generators(seed)
    agent.reset(episode, seed)
