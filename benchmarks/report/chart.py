"""Curves of success over time as SVG paths; the page's template draws them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from benchmarks.report.curves import Point, success_curve
from benchmarks.rows import Row

WIDTH: Final = 560
HEIGHT: Final = 260
LEFT, RIGHT, TOP, BOTTOM = 44, 18, 10, 34
"""[px] around the plot, for labels."""
_STEPS: Final = (1, 2, 5)


@dataclass(frozen=True)
class Line:
    """One agent's curve.

    Attributes:
        agent: whose.
        path: of the rates, for ``<path d=...>``.
        band: of their intervals, closed.
    """

    agent: str
    path: str
    band: str


@dataclass(frozen=True)
class Tick:
    """A mark on an axis.

    Attributes:
        at: [px] along it.
        label: what it says.
    """

    at: float
    label: str


@dataclass(frozen=True)
class Chart:
    """A plot of one task.

    Attributes:
        lines: of the agents with a finished episode.
        x_ticks: in control steps.
        y_ticks: in percent.
    """

    lines: tuple[Line, ...]
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]


def make_chart(rows: Mapping[str, Sequence[Row]]) -> Chart | None:
    """Plot of one task's rows by agent; None without a finished episode."""
    longest = max((row.steps for found in rows.values() for row in found), default=0)
    curves = {
        agent: curve for agent, found in rows.items() if (curve := success_curve(found, longest))
    }
    if not curves:
        return None
    longest = max(1, longest)
    return Chart(
        tuple(_line(agent, curve, longest) for agent, curve in curves.items()),
        tuple(Tick(_x(step, longest), str(step)) for step in _round_steps(longest)),
        tuple(Tick(_y(percent / 100), f"{percent}") for percent in (0, 25, 50, 75, 100)),
    )


def _line(agent: str, curve: Sequence[Point], longest: int) -> Line:
    xs = [_x(point.step, longest) for point in curve]
    until = [*xs[1:], xs[-1]]
    rates = _stairs(xs, until, [point.rate for point in curve])
    lows = _stairs(xs, until, [point.low for point in curve])
    highs = _stairs(xs, until, [point.high for point in curve])
    return Line(agent, f"M{' L'.join(rates)}", f"M{' L'.join([*highs, *reversed(lows)])}Z")


def _stairs(xs: Sequence[float], until: Sequence[float], values: Sequence[float]) -> list[str]:
    """Corners of a step function that keeps each value until the next."""
    return [
        f"{x:.1f},{_y(value):.1f}"
        for start, end, value in zip(xs, until, values, strict=True)
        for x in (start, end)
    ]


def _round_steps(longest: int) -> range:
    """At most seven multiples of 1, 2 or 5 times a power of ten, from 0 on."""
    size = next(
        base * 10**power for power in range(9) for base in _STEPS if 6 * base * 10**power >= longest
    )
    return range(0, longest + 1, size)


def _x(step: float, longest: int) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * step / longest


def _y(rate: float) -> float:
    return TOP + (HEIGHT - TOP - BOTTOM) * (1.0 - rate)
