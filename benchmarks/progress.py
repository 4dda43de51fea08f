"""Progress on stderr: a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from time import monotonic
from typing import Final

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.rows import Row
from benchmarks.runner import Watch

_LINES_WITHOUT_TERMINAL: Final = 10
_AGENTS_APART: Final = 4
"""So many agents have their rates shown one by one."""
_MEMORY: Final = 3600.0
"""[s] of the past that the time left is estimated from; one episode can take minutes."""


def watching(label: str) -> Watch:
    """Progress of one run.

    Args:
        label: what is running.
    """
    return _Watcher(label)


class _Watcher:
    def __init__(self, label: str) -> None:
        self._label = label

    @contextmanager
    def __call__(self, total: int, finished: Sequence[Row]) -> Iterator[Callable[[Row], None]]:
        rates = _Rates(finished)
        console = Console(stderr=True)
        if not console.is_terminal:
            clock = _Clock(total - len(finished))
            yield lambda row: _print_now_and_then(self._label, rates.add(row), total, clock)
            return
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
        )
        with Progress(*columns, console=console, speed_estimate_period=_MEMORY) as progress:
            label = escape(self._label)
            task = progress.add_task(label, total=total, completed=len(finished))

            def show(row: Row) -> None:
                rates.add(row)
                progress.update(task, advance=1, description=f"{label}: {rates}")

            yield show


class _Rates:
    """Counts so far, of each agent."""

    def __init__(self, finished: Sequence[Row]) -> None:
        self.rows = self._errors = 0
        self._ok: Counter[str] = Counter()
        self._won: Counter[str] = Counter()
        for row in finished:
            self.add(row)

    def add(self, row: Row) -> _Rates:
        self.rows += 1
        self._errors += row.status == "error"
        self._ok[row.agent] += row.status == "ok"
        self._won[row.agent] += row.status == "ok" and row.success
        return self

    def __str__(self) -> str:
        if 1 < len(self._ok) <= _AGENTS_APART:
            rates = ", ".join(f"{name} {self._won[name]}/{n}" for name, n in self._ok.items())
        else:
            rates = f"{self._won.total()}/{self._ok.total()}"
        return f"success {rates}" + (f", {self._errors} errors" if self._errors else "")


class _Clock:
    """How long the rest will take, if it goes on like this."""

    def __init__(self, missing: int) -> None:
        self._missing = missing
        self._begun = monotonic()

    def left(self, missing: int) -> str:
        done = self._missing - missing
        seconds = (monotonic() - self._begun) / max(1, done) * missing
        return str(timedelta(seconds=round(seconds)))


def _print_now_and_then(label: str, rates: _Rates, total: int, clock: _Clock) -> None:
    if rates.rows == total or rates.rows % max(1, total // _LINES_WITHOUT_TERMINAL) == 0:
        left = f", {clock.left(total - rates.rows)} left" if rates.rows < total else ""
        line = f"{label}: {rates.rows}/{total} episodes, {rates}{left}"
        print(line, file=sys.stderr, flush=True)
