"""Progress on stderr: a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.rows import Row
from benchmarks.runner import Watch

_LINES_WITHOUT_TERMINAL = 10


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
            yield lambda row: _print_now_and_then(self._label, rates.add(row), total)
            return
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
        )
        with Progress(*columns, console=console) as progress:
            label = escape(self._label)
            task = progress.add_task(label, total=total, completed=len(finished))

            def show(row: Row) -> None:
                rates.add(row)
                progress.update(task, advance=1, description=f"{label}: {rates}")

            yield show


class _Rates:
    """Counts so far."""

    def __init__(self, finished: Sequence[Row]) -> None:
        self.rows = self._ok = self._won = 0
        for row in finished:
            self.add(row)

    def add(self, row: Row) -> _Rates:
        self.rows += 1
        self._ok += row.status == "ok"
        self._won += row.status == "ok" and row.success
        return self

    def __str__(self) -> str:
        errors = self.rows - self._ok
        return f"success {self._won}/{self._ok}" + (f", {errors} errors" if errors else "")


def _print_now_and_then(label: str, rates: _Rates, total: int) -> None:
    if rates.rows == total or rates.rows % max(1, total // _LINES_WITHOUT_TERMINAL) == 0:
        print(f"{label}: {rates.rows}/{total} episodes, {rates}", file=sys.stderr, flush=True)
