"""Confidence intervals."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import NamedTuple


class Interval(NamedTuple):
    """Bounds of a rate, both in [0, 1]."""

    low: float
    high: float


def wilson(successes: float, n: int, confidence: float = 0.95) -> Interval | None:
    """Wilson's score interval of a rate (Wilson 1927, doi:10.1080/01621459.1927.10502953).

    A fractional sum, such as that of complete rates, is allowed: values in [0, 1] vary at most as
    much as 0/1 outcomes of the same mean do, so the interval is then too wide rather than too
    narrow.

    Args:
        successes: sum of n outcomes in [0, 1].
        n: number of outcomes; without any there is no interval.
        confidence: probability of covering the true rate.
    """
    if n == 0:
        return None
    if not 0.0 <= successes <= n:
        raise ValueError(f"successes must be in [0, n={n}], got {successes!r}")
    z = NormalDist().inv_cdf((1.0 + confidence) / 2.0)
    rate = successes / n
    shrunk = 1.0 + z * z / n
    centre = (rate + z * z / (2 * n)) / shrunk
    half = z * math.sqrt(rate * (1.0 - rate) / n + z * z / (4 * n * n)) / shrunk
    return Interval(
        low=0.0 if successes == 0 else max(0.0, centre - half),
        high=1.0 if successes == n else min(1.0, centre + half),
    )
