"""What callers hand in: refused with an error that names field, value and fix."""

from __future__ import annotations

from typing import Final

import numpy as np

from icd_envs.api import Float64Array
from icd_envs.errors import (
    InvalidActionError,
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
