"""Rates, means and intervals of rows, and the table of them."""

import pytest

from benchmarks.report.summaries import summarise
from benchmarks.rows import Row
from benchmarks.statistics import wilson
from benchmarks.tables import FOOTNOTE, print_summaries
from tests.bench.making import make_row

KEYS = [
    "agent",
    "env",
    "condition",
    "episodes",
    "errors",
    "success",
    "success_ci",
    "complete",
    "complete_ci",
]


def test_record_has_exactly_the_promised_keys_and_counts() -> None:
    rows = [
        make_row(success=True, complete=1.0, steps=20),
        make_row(success=True, complete=1.0, steps=40),
        make_row(complete=0.5),
        make_row(complete=0.0),
        make_row(status="error", complete=0.0, message="boom"),
    ]
    summary = summarise("a", "E-v0", "default", rows)
    record = summary.record()
    assert list(record) == KEYS
    assert (record["episodes"], record["errors"]) == (5, 1)
    assert (record["success"], record["complete"]) == (0.5, 0.625)
    assert record["success_ci"] == list(wilson(2, 4))
    assert record["complete_ci"] == list(wilson(2.5, 4))
    assert (summary.success_steps, summary.act_seconds) == (30, pytest.approx(0.1))


@pytest.mark.parametrize(
    ("rows", "success", "complete"),
    [
        ([], None, None),
        ([make_row(status="error", message="boom", complete=0.0)] * 3, None, None),
        ([make_row(success=True, complete=1.0)] * 3, 1.0, 1.0),
        ([make_row(complete=0.0)] * 3, 0.0, 0.0),
        ([make_row(success=True, complete=1.0)], 1.0, 1.0),
    ],
)
def test_extremes_have_a_table(
    rows: list[Row], success: float | None, complete: float | None, capsys: pytest.CaptureFixture
) -> None:
    summary = summarise("a", "E-v0", "default", rows)
    assert (summary.success, summary.complete) == (success, complete)
    for interval in (summary.success_ci, summary.complete_ci):
        assert interval is None if success is None else 0 <= interval.low < interval.high <= 1
    print_summaries([summary])
    assert ("n/a" in capsys.readouterr().out) == (success in (None, 0.0))


def test_table_shows_counts_intervals_and_privilege(capsys: pytest.CaptureFixture) -> None:
    rows = [make_row(success=i < 7, complete=float(i < 7)) for i in range(20)]
    honest = summarise("honest", "E-v0", "default", rows)
    print_summaries([honest])
    out = capsys.readouterr().out
    assert "7/20" in out
    assert "35.0 % [18.1, 56.7]" in out
    assert FOOTNOTE not in out
    print_summaries(
        [honest, summarise("planner", "E-v0", "default", [make_row(privileged="simulator")])]
    )
    out = capsys.readouterr().out
    assert "planner *" in out
    assert "honest *" not in out
    assert FOOTNOTE in out


def test_names_are_text_not_markup(capsys: pytest.CaptureFixture) -> None:
    print_summaries([summarise("[bold]x[/bold] [/]", "E-v0", "default", [])])
    assert "[bold]x[/bold] [/]" in capsys.readouterr().out
