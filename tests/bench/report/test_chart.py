"""Paths of the plot."""

import re

import pytest

from benchmarks.report.chart import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, make_chart
from tests.bench.making import make_row, make_rows


def corners(path: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in re.findall(r"([\d.]+),([\d.]+)", path)]


def test_line_goes_from_the_lower_left_to_the_upper_right() -> None:
    chart = make_chart({"a": make_rows("a", [True, True]), "b": [make_row(steps=100)]})
    assert chart is not None
    a, b = (corners(line.path) for line in chart.lines)
    assert a[0] == (LEFT, HEIGHT - BOTTOM)
    assert a[-1] == (WIDTH - RIGHT, TOP)
    assert {y for _, y in b} == {HEIGHT - BOTTOM}
    assert b[-1][0] == WIDTH - RIGHT
    for line in chart.lines:
        for x, y in corners(line.path) + corners(line.band):
            assert LEFT <= x <= WIDTH - RIGHT
            assert TOP <= y <= HEIGHT - BOTTOM


@pytest.mark.parametrize(
    ("longest", "labels"),
    [
        (300, ["0", "50", "100", "150", "200", "250", "300"]),
        (72, ["0", "20", "40", "60"]),
        (1, ["0", "1"]),
        (0, ["0", "1"]),
    ],
)
def test_ticks_are_round(longest: int, labels: list[str]) -> None:
    chart = make_chart({"a": [make_row(steps=longest)]})
    assert chart is not None
    assert [tick.label for tick in chart.x_ticks] == labels


def test_without_finished_episodes_there_is_no_plot() -> None:
    assert make_chart({"a": [make_row(status="error", message="x")], "b": []}) is None
    assert make_chart({}) is None
