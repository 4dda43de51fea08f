"""Progress of training on stderr: a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from time import monotonic
from typing import Final

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from icd_agent.training.loop import Seen

_LINES_WITHOUT_TERMINAL: Final = 20


@contextmanager
def training(label: str, steps: int) -> Iterator[Seen]:
    """Show how far a training run is and what its loss is.

    Args:
        label: what is trained.
        steps: in all.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(label, steps)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task(escape(label), total=steps)

        def show(step: int, terms: dict[str, float]) -> None:
            text = escape(f"{label}: loss {terms['loss']:.4g}" if terms else label)
            progress.update(task, completed=step, description=text)

        yield show


class _Lines:
    """Prints about twenty lines, with all terms and the time left."""

    def __init__(self, label: str, steps: int) -> None:
        self._label, self._steps = label, steps
        self._begun, self._printed = monotonic(), -1
        self._first: int | None = None

    def __call__(self, step: int, terms: dict[str, float]) -> None:
        """Show one step."""
        if self._first is None:
            self._begun, self._first = monotonic(), step
        part = _LINES_WITHOUT_TERMINAL * step // self._steps
        if part == self._printed and step < self._steps:
            return
        self._printed = part
        done = max(1, step - self._first)
        left = (monotonic() - self._begun) / done * (self._steps - step)
        shown = "".join(f", {name} {value:.4g}" for name, value in terms.items())
        line = f"{self._label}: {step}/{self._steps} steps{shown}"
        rest = (
            f", {timedelta(seconds=round(left))} left" if self._first < step < self._steps else ""
        )
        print(line + rest, file=sys.stderr, flush=True)
