"""What wrappers demand of the environment that they wrap."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from icd_envs.api import Float32Array
from icd_envs.errors import InvalidObservationError, InvalidOptionError


def box_parts(env: gym.Env[Any, Any], wrapper: str) -> dict[str, spaces.Box]:
    """The parts of a dictionary observation, in the space's own order.

    Args:
        env: what is wrapped.
        wrapper: by whom, for the message.

    Raises:
        InvalidOptionError: if it does not observe a dictionary of arrays.
    """
    space = env.observation_space
    if not isinstance(space, spaces.Dict):
        raise InvalidOptionError(
            f"{wrapper} needs an environment that observes a dictionary of arrays, got {space}: "
            "wrap the environment itself, before other wrappers"
        )
    parts = {name: part for name, part in space.spaces.items() if isinstance(part, spaces.Box)}
    if len(parts) != len(space.spaces):
        other = sorted(space.spaces.keys() - parts.keys())
        raise InvalidOptionError(f"{wrapper} needs arrays only, {other} are not")
    return parts


def is_finite(value: object) -> bool:
    """Whether it is a number, and neither NaN nor infinite."""
    return isinstance(value, Real) and math.isfinite(value)


def check_part(name: str, value: object, shape: tuple[int, ...]) -> Float32Array:
    """One part of an observation as finite float32.

    Raises:
        InvalidObservationError: if it has another shape or holds NaN or infinite values.
    """
    array = np.asarray(value)
    if array.shape != shape:
        raise InvalidObservationError(
            f"observation[{name!r}] has shape {array.shape}, its space says {shape}: the wrapped "
            "environment must pad its clouds to a fixed size"
        )
    array = array.astype(np.float32)
    if not np.all(np.isfinite(array)):
        raise InvalidObservationError(
            f"observation[{name!r}] holds NaN or infinite values: the wrapped environment must "
            "replace points that it does not see, e.g. by 0 with a mask"
        )
    return array
