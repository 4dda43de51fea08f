"""Success over time: the share of episodes that had succeeded after so many steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.rows import Row
from benchmarks.statistics import wilson


@dataclass(frozen=True)
class Point:
    """One corner of a curve.

    Attributes:
        step: control steps taken.
        rate: share of the finished episodes that have succeeded by then.
        low: lower bound of its pointwise 95 % Wilson interval.
        high: upper bound.
    """

    step: int
    rate: float
    low: float
    high: float


def success_curve(rows: Sequence[Row], until: int) -> list[Point]:
    """A step function, one point for every number of steps at which an episode succeeded.

    An episode that fails, for whatever reason, counts as one that never succeeds. An episode ends
    when its success has held, so that its number of steps is the time of its success.

    Args:
        rows: of one agent on one task.
        until: step to which the curve goes on after its last rise.

    Returns:
        From step 0 on; empty without a finished episode.
    """
    finished = [row for row in rows if row.status == "ok"]
    if not finished:
        return []
    won = sorted(row.steps for row in finished if row.success)
    steps = sorted({0, *won, until})
    return [_point(step, sum(s <= step for s in won), len(finished)) for step in steps]


def _point(step: int, successes: int, n: int) -> Point:
    interval = wilson(successes, n)
    assert interval is not None
    return Point(step, successes / n, interval.low, interval.high)
