"""One way to refuse a bad value of a configuration field."""

from __future__ import annotations

import math

from icd_envs.errors import InvalidOptionError


def require(ok: bool, field: str, value: object, valid: str) -> None:
    """Refuse a value by naming the field, the value received and what would be valid.

    Args:
        ok: whether the value can be used.
        field: name of the field or argument, as the caller wrote it.
        value: what was received.
        valid: what would have been valid, e.g. ``"an integer >= 1"``.

    Raises:
        InvalidOptionError: if not ``ok``.
    """
    if not ok:
        raise InvalidOptionError(f"{field}={value!r} cannot be used: give {valid}")


def is_finite(value: object) -> bool:
    """Whether a value is a number other than NaN and the infinities."""
    return isinstance(value, (int, float)) and math.isfinite(value)


def is_positive(value: object) -> bool:
    """Whether a value is a finite number above 0."""
    return isinstance(value, (int, float)) and math.isfinite(value) and value > 0


def is_count(value: object) -> bool:
    """Whether a value is an integer of at least 1 (True is not a count)."""
    return isinstance(value, int) and not isinstance(value, bool) and value >= 1
