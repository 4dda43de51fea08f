"""The scripted expert as an agent: the ceiling of every table. Privileged."""

from __future__ import annotations

import numpy as np

from icd_envs.api import Episode, Float32Array, Observation
from icd_envs.demonstrations import find_task
from icd_envs.errors import NOT_BEGUN, EpisodeStateError, InvalidOptionError
from icd_envs.tasks.base import Expert


class ExpertAgent:
    """Acts from the true geometry of the scene; it solved the same scene to make the goal."""

    needs_simulator = False
    needs_oracle = True

    def __init__(self) -> None:
        """Nothing to configure."""
        self._expert: Expert | None = None

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; the clean expert draws nothing, so ``seed`` has no effect.

        Raises:
            InvalidOptionError: if the episode has no oracle.
        """
        if episode.oracle is None:
            raise InvalidOptionError(
                "episode.oracle=None, but the expert needs the scene: "
                "build the episode with oracle=True"
            )
        self._expert = find_task(episode.env_id).make_expert(episode.oracle.scene)

    def act(self, observation: Observation) -> Float32Array:
        """Return the expert's action, (3,) in [-1, 1].

        Raises:
            EpisodeStateError: before ``reset``.
        """
        if self._expert is None:
            raise EpisodeStateError(NOT_BEGUN)
        action = self._expert.act(observation["observation"][:3], observation["achieved_goal"])
        return action.astype(np.float32)
