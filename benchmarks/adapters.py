"""What is no agent, as an agent."""

from __future__ import annotations

from collections.abc import Callable

from icd_envs.api import Episode, FloatArray, Observation

Policy = Callable[[Observation], FloatArray]


class FunctionAgent:
    """A plain function of the observation; it remembers nothing."""

    def __init__(self, policy: Policy) -> None:
        """Act as it says.

        Args:
            policy: returns an action, (3,) in [-1, 1].
        """
        self._policy = policy

    def reset(self, episode: Episode, seed: int) -> None:
        """Nothing to begin."""

    def act(self, observation: Observation) -> FloatArray:
        """What the function returns."""
        return self._policy(observation)
