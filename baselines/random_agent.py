"""Uniformly random actions: the floor of every table."""

from __future__ import annotations

import numpy as np

from icd_envs.api import Episode, Float32Array, Observation
from icd_envs.errors import NOT_BEGUN, EpisodeStateError


class RandomAgent:
    """Draws every action uniformly from the box."""

    def __init__(self) -> None:
        """Wait for ``reset``."""
        self._rng: np.random.Generator | None = None

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; ``seed`` is the only source of randomness."""
        self._rng = np.random.default_rng(seed)

    def act(self, observation: Observation) -> Float32Array:
        """Return an action, (3,) in [-1, 1].

        Raises:
            EpisodeStateError: before ``reset``.
        """
        if self._rng is None:
            raise EpisodeStateError(NOT_BEGUN)
        return self._rng.uniform(-1.0, 1.0, size=3).astype(np.float32)
