"""A planner whose model is wrong: robots have no simulator of the very cable that they hold."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym

from icd_envs.api import Episode
from icd_envs.errors import InvalidOptionError
from icd_envs.wrappers.checks import is_finite


class MismatchedPlanner(gym.Wrapper[Any, Any, Any, Any], gym.utils.RecordConstructorArgs):
    """Hand planners a simulator whose object and friction differ from the environment's own.

    The environment itself stays as it is, and so do all agents without a simulator.
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        stiffness: float = 1.0,
        mass: float = 1.0,
        friction: float = 1.0,
    ) -> None:
        """Wrap.

        Args:
            env: one of this project's.
            stiffness: of the object's hinges, as a multiple of the true one.
            mass: of the object, as a multiple of the true one.
            friction: sliding friction of everything, as a multiple of the true one.

        Raises:
            InvalidOptionError: if a factor is not finite and positive.
        """
        factors = {"stiffness": stiffness, "mass": mass, "friction": friction}
        for name, factor in factors.items():
            if not (is_finite(factor) and factor > 0.0):
                raise InvalidOptionError(f"{name} must be finite and > 0, got {factor!r}")
        gym.utils.RecordConstructorArgs.__init__(
            self, stiffness=stiffness, mass=mass, friction=friction
        )
        super().__init__(env)
        self._factors = factors

    def episode(
        self, *, simulator: bool = False, oracle: bool = False, threads: int = 1
    ) -> Episode:
        """As the environment's own, but for the dynamics of the simulator.

        Raises:
            InvalidOptionError: the environment's simulator is none of this project's.
        """
        begin = self.env.get_wrapper_attr("episode")
        episode: Episode = begin(simulator=simulator, oracle=oracle, threads=threads)
        if episode.simulator is None:
            return episode
        from icd_envs.physics.mismatch import mismatched
        from icd_envs.physics.simulator import RolloutSimulator

        if not isinstance(episode.simulator, RolloutSimulator):
            raise InvalidOptionError(
                f"MismatchedPlanner needs this project's simulator, got {episode.simulator!r}"
            )
        return replace(episode, simulator=mismatched(episode.simulator, **self._factors))
