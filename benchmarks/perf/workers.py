"""Do two workers take little more than half the time of one? ``python -m benchmarks.perf.workers``.

Both run the same PC-MPPI episodes with one planner thread per worker, from the command line, start
of the processes included. Exit code 0 if the bound is kept and the rows are the same. Only an
otherwise idle machine with two cores tells.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Annotated, Final

import typer

from benchmarks.results import read_rows

BOUND: Final = 0.6
"""Time of two workers over time of one."""


def main(
    agent: Annotated[str, typer.Option(help="Agent to measure with.")] = "pc-mppi",
    env: Annotated[str, typer.Option(help="Environment id.")] = "ICDCableRouting-v0",
    episodes: Annotated[int, typer.Option(min=2, help="Episodes.")] = 4,
) -> None:
    """Compare the wall time of one and two workers."""
    with TemporaryDirectory() as folder:
        task = ["--agent", agent, "--env", env, "--episodes", str(episodes)]
        one, two = (_measure(task, workers, Path(folder, str(workers))) for workers in (1, 2))
        rows = [_rows(Path(folder, str(workers))) for workers in (1, 2)]
    ratio = two / one
    print(f"one worker {one:.1f} s, two workers {two:.1f} s, ratio {ratio:.3f}, bound {BOUND}")
    if rows[0] != rows[1]:
        print("the rows differ")
    raise typer.Exit(0 if ratio <= BOUND and rows[0] == rows[1] else 1)


def _measure(task: list[str], workers: int, out: Path) -> float:
    """[s] of one run."""
    how = ["--workers", str(workers), "--threads", "1", "--out", str(out)]
    before = perf_counter()
    subprocess.run(
        [sys.executable, "-m", "benchmarks", "run", *task, *how],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return perf_counter() - before


def _rows(out: Path) -> list[str]:
    return sorted(row.without_times().to_line() for row in read_rows(out))


if __name__ == "__main__":
    typer.run(main)
