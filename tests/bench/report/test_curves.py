"""Success over time."""

from benchmarks.report.curves import success_curve
from benchmarks.rows import Row
from benchmarks.statistics import wilson
from tests.bench.making import make_row


def won(steps: int) -> Row:
    return make_row(success=True, complete=1.0, steps=steps)


def test_curve_rises_at_every_success_and_stays() -> None:
    rows = [won(30), won(10), won(10), make_row(steps=50), make_row(status="error", message="x")]
    curve = success_curve(rows, until=80)
    assert [(p.step, p.rate) for p in curve] == [(0, 0.0), (10, 0.5), (30, 0.75), (80, 0.75)]
    assert (curve[1].low, curve[1].high) == wilson(2, 4)


def test_failures_alone_stay_at_zero_and_nothing_is_nothing() -> None:
    assert [p.rate for p in success_curve([make_row(steps=50)], until=50)] == [0.0, 0.0]
    assert success_curve([make_row(status="error", message="x")], until=50) == []
    assert success_curve([], until=50) == []
