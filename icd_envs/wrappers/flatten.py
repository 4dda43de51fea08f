"""One vector for learners that take nothing else."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from icd_envs.api import Float32Array
from icd_envs.wrappers.checks import box_parts, check_part


class FlattenPointCloud(
    gym.ObservationWrapper[Float32Array, Any, Any], gym.utils.RecordConstructorArgs
):
    """Observe one float32 vector, the parts in alphabetical order, points one after the other.

    Wrap ``SubsamplePointCloud`` to keep it short: all points make 7,206 numbers. Goals can no
    longer be relabelled; for that, stay with dictionaries.

    Attributes:
        slices: where in the vector each part is.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        """Lay the vector out.

        Args:
            env: an environment that observes a dictionary of arrays.

        Raises:
            InvalidOptionError: if it does not.
        """
        gym.utils.RecordConstructorArgs.__init__(self)
        super().__init__(env)
        self._parts = box_parts(env, type(self).__name__)
        ends = np.cumsum([0, *(int(np.prod(part.shape)) for part in self._parts.values())])
        self.slices = {n: slice(int(ends[i]), int(ends[i + 1])) for i, n in enumerate(self._parts)}
        self.observation_space = spaces.Box(
            np.concatenate([part.low.ravel() for part in self._parts.values()], dtype=np.float32),
            np.concatenate([part.high.ravel() for part in self._parts.values()], dtype=np.float32),
            dtype=np.float32,
        )

    def observation(self, observation: dict[str, Any]) -> Float32Array:
        """(D,) all parts in a row.

        Raises:
            InvalidObservationError: on a wrong shape, NaN or infinite values.
        """
        return np.concatenate(
            [check_part(n, observation[n], s.shape).ravel() for n, s in self._parts.items()]
        )
