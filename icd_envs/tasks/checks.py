"""What callers hand in: refused with an error that names field, value and fix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from icd_envs.api import Float64Array, FloatArray
from icd_envs.errors import (
    InvalidActionError,
    InvalidObservationError,
    InvalidOptionError,
    InvalidSeedError,
    unknown_name,
)

SEED_LIMIT: Final = 2**64
"""Minari's collector draws seeds of 64 bits."""


def check_action(action: object) -> Float64Array:
    """An action as 3 float64, not yet clipped.

    Raises:
        InvalidActionError: if it is not 3 finite numbers.
    """
    fix = "send 3 finite numbers in [-1, 1], e.g. env.action_space.sample()"
    try:
        array = np.asarray(action)
        if array.dtype.kind not in "fiu":
            raise InvalidActionError(f"action has dtype {array.dtype}, expected floats: {fix}")
    except (TypeError, ValueError, RuntimeError) as error:
        if isinstance(error, InvalidActionError):
            raise
        raise InvalidActionError(
            f"action of type {type(action).__name__} does not convert to an array of shape (3,) "
            f"({error}): {fix}"
        ) from error
    if array.shape != (3,):
        raise InvalidActionError(f"action has shape {array.shape}, expected (3,): {fix}")
    if not np.all(np.isfinite(array)):
        raise InvalidActionError(f"action is {array.tolist()}, not finite: {fix}")
    return array.astype(np.float64)


def check_goals(achieved: object, desired: object) -> tuple[FloatArray, FloatArray]:
    """Achieved and desired clouds as arrays of one shape, (N, 3) or (B, N, 3).

    Raises:
        InvalidObservationError: if they are not such clouds of finite numbers.
    """
    one, other = _check_cloud("achieved_goal", achieved), _check_cloud("desired_goal", desired)
    if one.shape != other.shape:
        raise InvalidObservationError(
            f"achieved_goal has shape {one.shape}, desired_goal {other.shape}: pass as many "
            "clouds of as many points"
        )
    return one, other


def _check_cloud(name: str, value: object) -> FloatArray:
    expected = "expected (N, 3) or (B, N, 3) finite numbers: pass what was observed"
    try:
        cloud = np.asarray(value)
    except (TypeError, ValueError, RuntimeError) as error:
        raise InvalidObservationError(f"{name} is no array ({error}), {expected}") from error
    is_cloud = cloud.ndim in (2, 3) and cloud.shape[-1] == 3 and cloud.shape[-2] > 0
    if cloud.dtype.kind not in "fiu" or not is_cloud:
        raise InvalidObservationError(
            f"{name} has shape {cloud.shape} and dtype {cloud.dtype}, {expected}"
        )
    if not np.all(np.isfinite(cloud)):
        raise InvalidObservationError(f"{name} holds NaN or infinite values, {expected}")
    return cloud


def stack_parameters(
    infos: Sequence[Mapping[str, Any]], names: Sequence[str], count: int
) -> dict[str, Float64Array]:
    """What a reward needs to know of the scenes, (B, ...) for each name.

    Args:
        infos: of each item.
        names: keys of every info.
        count: B.

    Raises:
        InvalidObservationError: if there are not B infos, or one lacks a name.
    """
    if len(infos) != count:
        raise InvalidObservationError(f"{len(infos)} infos for {count} clouds: pass one for each")
    for info in infos:
        if not isinstance(info, Mapping) or not set(names) <= info.keys():
            raise InvalidObservationError(
                f"info is {info!r}, it needs the keys {', '.join(names)}: pass the info that step "
                "returned (Stable-Baselines3: HerReplayBuffer(..., copy_info_dict=True))"
            )
    return {name: np.array([info[name] for info in infos]) for name in names}


def check_reset_options(options: object) -> None:
    """Refuse every option of ``reset``: no key is known yet.

    Raises:
        InvalidOptionError: if it is neither None nor an empty mapping.
    """
    if options is None:
        return
    if not isinstance(options, Mapping):
        raise InvalidOptionError(
            f"reset options must be a dictionary, got {options!r} of type "
            f"{type(options).__name__}: leave options out"
        )
    for key in options:
        raise InvalidOptionError(unknown_name("reset option", key, ()))


def check_seed(seed: object) -> int:
    """A reset seed as an int.

    Raises:
        InvalidSeedError: if it is not an integer in [0, 2**64).
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise InvalidSeedError(
            f"seed must be an integer in [0, {SEED_LIMIT}), got {seed!r} of type "
            f"{type(seed).__name__}: pass e.g. seed=0"
        )
    if not 0 <= int(seed) < SEED_LIMIT:
        raise InvalidSeedError(f"seed must be in [0, {SEED_LIMIT}), got {seed}: pass e.g. seed=0")
    return int(seed)


def check_integer(name: str, value: object, low: int, high: int) -> None:
    """Refuse what is not an integer in [low, high].

    Raises:
        InvalidOptionError: naming option, value and range.
    """
    if type(value) is not int or not low <= value <= high:
        raise InvalidOptionError(f"{name} must be an integer in [{low}, {high}], got {value!r}")


def check_choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    """Refuse a value that is not one of ``choices``.

    Raises:
        InvalidOptionError: naming option, value and choices.
    """
    if value not in choices:
        raise InvalidOptionError(unknown_name(f"value of {name!r}:", value, choices))
