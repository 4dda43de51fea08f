"""Intervals and paired tests; nothing is called better without one."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from statistics import NormalDist
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

CONFIDENCE: Final = 0.95
RESAMPLES: Final = 9999
_SEED: Final = 20250101
"""Resampling is repeatable: the same rows give the same report."""


class Interval(NamedTuple):
    """Bounds of a quantity."""

    low: float
    high: float


def wilson(successes: float, n: int, confidence: float = CONFIDENCE) -> Interval | None:
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


def bootstrap_mean(
    values: Sequence[float], cases: Sequence[Hashable], confidence: float = CONFIDENCE
) -> Interval | None:
    """Percentile bootstrap interval of a mean; whole test cases are drawn, with their repeats.

    With few cases, or values that hardly differ, it is too narrow: nothing that was not seen is
    ever drawn.

    Args:
        values: (n,) one of each episode.
        cases: (n,) which test case each belongs to.
        confidence: probability of covering the true mean, for many cases.

    Returns:
        None with fewer than two cases.
    """
    numbers = {case: i for i, case in enumerate(dict.fromkeys(cases))}
    if len(numbers) < 2:
        return None
    case = np.array([numbers[case] for case in cases])
    outcomes = np.stack([np.bincount(case, weights=values), np.bincount(case)], axis=1)
    # Cases with the same outcome are alike: it is enough to draw how many of each there are.
    distinct, counts = np.unique(outcomes, axis=0, return_counts=True)
    rng = np.random.default_rng(_SEED)
    draws = rng.multinomial(len(numbers), counts / len(numbers), RESAMPLES)
    sums, episodes = distinct.T
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile((draws @ sums) / (draws @ episodes), [tail, 1.0 - tail])
    return Interval(float(low), float(high))


def paired_p(first: Sequence[bool], second: Sequence[bool], cases: Sequence[Hashable]) -> float:
    """Two-sided p-value of "both succeed equally often", on the same episodes.

    With one episode per case it is McNemar's exact test. Repeats on one case are not independent:
    then the difference of each case as a whole is given random signs, which for single episodes
    is the same test.

    Args:
        first: (n,) successes of one agent.
        second: (n,) successes of the other, in the same episodes.
        cases: (n,) which test case each episode belongs to.
    """
    from scipy import stats

    differences: dict[Hashable, int] = dict.fromkeys(cases, 0)
    for won, lost, case in zip(first, second, cases, strict=True):
        differences[case] += int(won) - int(lost)
    decided: list[int] = [difference for difference in differences.values() if difference]
    if not decided:
        return 1.0
    if len(differences) == len(cases):
        wins = sum(difference > 0 for difference in decided)
        return float(stats.binomtest(wins, len(decided)).pvalue)
    return _sign_flip_p(np.array(decided))


def _sign_flip_p(differences: NDArray[np.int64]) -> float:
    """Share of all signs whose sum is as far from 0 as that of the differences; exact.

    The distribution of the sum is built up one difference at a time.
    """
    reach = int(np.abs(differences).sum())
    chance = np.zeros(2 * reach + 1)
    chance[reach] = 1.0
    for size in np.abs(differences):
        chance = 0.5 * (np.roll(chance, size) + np.roll(chance, -size))
    sums = np.arange(-reach, reach + 1)
    return float(min(1.0, chance[np.abs(sums) >= abs(int(differences.sum()))].sum()))


def fisher_p(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Two-sided p-value of Fisher's exact test, for runs that share no cases.

    Args:
        first: successes and episodes.
        second: successes and episodes.
    """
    from scipy import stats

    table = [[won, n - won] for won, n in (first, second)]
    return float(stats.fisher_exact(table).pvalue)


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's step-down correction: p-values that may be read together (Holm 1979)."""
    count = len(p_values)
    adjusted = [0.0] * count
    largest = 0.0
    for rank, i in enumerate(sorted(range(count), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, (count - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted
