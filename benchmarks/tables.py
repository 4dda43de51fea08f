"""Tables for the terminal; names from outside are text, never markup."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from benchmarks.conditions import task_title
from benchmarks.gates import Gate, Verdict
from benchmarks.report.summaries import Summary
from benchmarks.reproduce import Pair, verdict_on
from benchmarks.rows import Row
from benchmarks.statistics import Interval

_WIDTH_WITHOUT_TERMINAL = 140
FOOTNOTE = "* privileged: uses the simulator's state or the expert's solution"


def print_summaries(summaries: Sequence[Summary], warnings: Sequence[str] = ()) -> None:
    """Print one line per agent and task on stdout, and what to know of them below."""
    table = Table()
    for heading in ("env", "agent"):
        table.add_column(heading, overflow="fold")
    for heading in ("success", "", "complete", "steps", "ms/act", "errors"):
        table.add_column(heading, justify="right", no_wrap=True)
    for summary in summaries:
        finished = summary.episodes - summary.errors
        table.add_row(
            Text(task_title(summary.env, summary.condition)),
            Text(summary.agent + (" *" if summary.privileged else "")),
            f"{summary.successes}/{finished}",
            _percent(summary.success, summary.success_ci),
            _percent(summary.complete, summary.complete_ci),
            _number(summary.success_steps, "{:.0f}"),
            _number(None if summary.act_seconds is None else 1e3 * summary.act_seconds, "{:.1f}"),
            f"{summary.errors}",
        )
    console = _console()
    console.print(table)
    console.print(
        Text("95 % Wilson intervals; steps: mean over successes; errors count in no rate")
    )
    if any(summary.privileged for summary in summaries):
        console.print(Text(FOOTNOTE))
    for warning in warnings:
        console.print(Text(f"note: {warning}"), soft_wrap=True)


def print_rows(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a plain table on stdout."""
    table = Table()
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    _console().print(table)


def print_verdicts(gates: Sequence[Gate], verdicts: Mapping[str, Verdict]) -> None:
    """Print one line per gate on stdout."""
    rows = [
        (
            gate.name,
            _number(verdicts[gate.name].value, "{:.3g}"),
            f"{gate.direction} {gate.bound}",
            str(verdicts[gate.name].n),
            "ok" if verdicts[gate.name].ok else "NOT OK",
        )
        for gate in gates
    ]
    print_rows(("gate", "value", "bound", "n", "verdict"), rows)


def print_pairs(pairs: Sequence[Pair], changed: Sequence[str]) -> None:
    """Print how episodes ended when they were recorded and now, and what has changed since."""
    rows = [
        (
            task_title(recorded.env, recorded.condition),
            recorded.agent,
            str(recorded.index),
            _ending(recorded),
            _ending(now),
            verdict_on(recorded, now),
        )
        for recorded, now in pairs
    ]
    print_rows(("env", "agent", "case", "recorded", "now", "verdict"), rows)
    console = _console()
    for change in changed:
        console.print(Text(f"note: changed since: {change}"), soft_wrap=True)


def _ending(row: Row) -> str:
    if row.status == "error":
        return "error"
    return f"{'success' if row.success else 'failure'}, {row.steps} steps"


def print_values(values: Mapping[str, int | float | str | None]) -> None:
    """Print names and values on stdout, every digit of integers."""
    print_rows(
        ("what", "value"),
        [
            (name, f"{value:.4g}" if isinstance(value, float) else str(value))
            for name, value in values.items()
        ],
    )


def _console() -> Console:
    return Console(width=None if sys.stdout.isatty() else _WIDTH_WITHOUT_TERMINAL)


def _percent(rate: float | None, interval: Interval | None) -> str:
    if rate is None or interval is None:
        return "n/a"
    return f"{100 * rate:.1f} % [{100 * interval.low:.1f}, {100 * interval.high:.1f}]"


def _number(value: float | None, form: str) -> str:
    return "n/a" if value is None else form.format(value)
