"""Run a plan into a results folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from functools import partial
from pathlib import Path

from benchmarks.executors import execute
from benchmarks.plan import Job, Plan
from benchmarks.provenance import cpu_count
from benchmarks.results import open_results
from benchmarks.rows import Row, error_row

Work = Callable[[Job], Row]
Watch = Callable[[int, Sequence[Row]], AbstractContextManager[Callable[[Row], None]]]
"""Given the number of all jobs and the earlier rows: a context that is shown each new row."""


@contextmanager
def unwatched(total: int, finished: Sequence[Row]) -> Iterator[Callable[[Row], None]]:
    """Show no progress."""
    yield lambda row: None


def episodes(workers: int) -> Work:
    """Work that runs an agent; planner threads share the cores with the other workers."""
    from benchmarks.episode import run_episode

    return partial(run_episode, threads=max(1, cpu_count() // workers))


def run(
    plan: Plan,
    out: Path,
    work: Work,
    *,
    workers: int = 1,
    resume: bool = False,
    watch: Watch = unwatched,
) -> list[Row]:
    """Do every job of the plan that has no row yet.

    Args:
        plan: what to run.
        out: results folder.
        work: picklable function that does one job, e.g. ``episodes(workers)``.
        workers: processes; with 1 everything happens in this one.
        resume: go on with results that are in the folder.
        watch: shows progress.

    Returns:
        All rows of the folder, earlier ones included.

    Raises:
        ResultsError: the folder cannot be used; nothing in it was changed.
    """
    jobs = plan.jobs()
    with open_results(out, plan, resume=resume) as folder:
        finished = {row.key for row in folder.rows}
        pending = [job for job in jobs if job.key not in finished]
        with (
            watch(len(jobs), tuple(folder.rows)) as seen,
            closing(execute(work, pending, workers, _lost)) as rows,
        ):
            for row in rows:
                folder.append(row)
                seen(row)
        return folder.rows


def _lost(job: Job) -> Row:
    return error_row(job, "worker died: the process was killed or crashed, twice")
