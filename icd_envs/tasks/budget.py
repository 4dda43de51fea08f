"""Gymnasium's ``max_episode_steps`` as an environment's own budget of steps."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
from gymnasium.wrappers import TimeLimit

from icd_envs.registration import OWN_BUDGET
from icd_envs.tasks.env import ContactEnv


def take_budget(env: gym.Env[Any, Any]) -> gym.Env[Any, Any]:
    """Let the environment itself keep the limit that ``gymnasium.make`` has put around it.

    ``make`` does not tell an environment of ``max_episode_steps`` but wraps ``TimeLimit`` around
    it, of which planners hear nothing and whose count is in no snapshot. What a registration calls
    a wrapper is applied after that one, and this one takes it off again.

    Args:
        env: one of this project's, as ``make`` leaves it.

    Returns:
        the same without ``TimeLimit``; its spec tells ``make`` to do so again.
    """
    inner = env.unwrapped
    assert isinstance(inner, ContactEnv)
    assert inner.spec is not None
    assert env.spec is not None
    if isinstance(env, TimeLimit):
        assert env.spec.max_episode_steps is not None
        inner.max_steps = inner.spec.max_episode_steps = env.spec.max_episode_steps
        env = env.env
    inner.spec.additional_wrappers = (OWN_BUDGET,)
    return env
