"""What agents are shown, before they act on it: whole, finite, in single precision."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, cast

import numpy as np

from icd_envs.api import Float32Array, Observation
from icd_envs.errors import InvalidObservationError

CLOUDS: Final = ("achieved_goal", "desired_goal", "scene", "goal_scene")
MASK: Final = "_mask"
"""What follows a cloud's name in the name of its mask, in a partial view."""


def checked(observation: object, points: int | None = None) -> Observation:
    """An observation that can be acted on; of float32 arrays, the same arrays.

    Args:
        observation: as environments give it; other numbers are converted.
        points: N of the object's clouds; None is any.

    Raises:
        InvalidObservationError: no dictionary, a part that is missing, of another shape or not
            finite.
    """
    if not isinstance(observation, Mapping):
        raise InvalidObservationError(
            f"observation is {type(observation).__name__}, expected the environment's dictionary: "
            "leave out FlattenPointCloud and other wrappers that flatten it"
        )
    parts: dict[str, Any] = {**observation, "observation": _part(observation, "observation", (6,))}
    for name in CLOUDS:
        count = points if name.endswith("d_goal") else None
        parts[name] = _part(observation, name, (count, 3))
        if name + MASK in observation:
            parts[name + MASK] = _part(observation, name + MASK, (len(parts[name]),))
    return cast(Observation, parts)


def _part(observation: Mapping[str, Any], name: str, shape: tuple[int | None, ...]) -> Float32Array:
    if name not in observation:
        raise InvalidObservationError(
            f"observation has no {name!r}, only {', '.join(map(repr, observation))}: give all that "
            "the environment observes"
        )
    try:
        part = np.asarray(observation[name], np.float32)
    except (TypeError, ValueError) as error:
        raise InvalidObservationError(f"{name} is no array of numbers: {error}") from error
    same = part.ndim == len(shape) and part.size > 0
    if not same or any(b not in (None, a) for a, b in zip(part.shape, shape, strict=True)):
        expected = str(shape).replace("None", "N")
        raise InvalidObservationError(
            f"{name} has shape {part.shape}, expected {expected}: give whole clouds, as the "
            "environment observes them"
        )
    if not np.isfinite(part).all():
        raise InvalidObservationError(f"{name} has NaN or infinite values: give finite ones")
    return part
