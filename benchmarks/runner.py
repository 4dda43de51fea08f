"""Run a plan into a results folder."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from functools import partial
from pathlib import Path

from benchmarks.attempt import RENDERING, Attempt, Played, Settings
from benchmarks.errors import ResultsWarning
from benchmarks.executors import Executor, Retry, Work
from benchmarks.plan import Job, Plan
from benchmarks.results import open_results
from benchmarks.rows import Row, error_row
from benchmarks.videos import Choice, save_video
from benchmarks.worker import Loss

Episodes = Work[Attempt, Played]
Watch = Callable[[int, Sequence[Row]], AbstractContextManager[Callable[[Row], None]]]
"""Given the number of all jobs and the earlier rows: a context that is shown each new row."""


@contextmanager
def unwatched(total: int, finished: Sequence[Row]) -> Iterator[Callable[[Row], None]]:
    """Show no progress."""
    yield lambda row: None


def episodes(settings: Settings) -> Episodes:
    """Work that runs agents, each in processes of its own."""
    from benchmarks.episode import play

    return Work(
        partial(play, settings=settings),
        lost,
        group=_agent,
        seconds=settings.episode_seconds,
    )


def lost(attempt: Attempt, loss: Loss) -> Played | Retry[Attempt]:
    """Row of an episode whose worker hung or died; if that was for a video, another go without."""
    if attempt.film and loss.doing == RENDERING:
        warnings.warn(f"no video of {attempt.job.key}: {loss}", ResultsWarning, stacklevel=2)
        return Retry(attempt._replace(film=False))
    return Played(error_row(attempt.job, str(loss), steps=loss.step, seconds=loss.seconds))


def _may_be_shown(job: Job, videos: Choice | None) -> bool:
    """Whether an episode is filmed; how it ends is not known yet."""
    return videos in ("failures", "all") or (videos == "first" and job.index == job.repeat == 0)


def _agent(attempt: Attempt) -> str:
    return attempt.job.agent


def run(
    plan: Plan,
    out: Path,
    work: Episodes,
    executor: Executor,
    *,
    settings: Mapping[str, str | float] | None = None,
    videos: Choice | None = None,
    resume: bool = False,
    allow_mixed: bool = False,
    retry_errors: bool = False,
    watch: Watch = unwatched,
) -> list[Row]:
    """Do every job of the plan that has no row yet.

    Args:
        plan: what to run.
        out: results folder.
        work: what makes a row of a job, e.g. ``episodes(Settings())``.
        executor: who does it.
        settings: what decides how episodes end, for the manifest.
        videos: which episodes leave a video in the folder.
        resume: go on with results that are in the folder.
        allow_mixed: even if they are of other settings, code or versions.
        retry_errors: jobs whose row is an error have none yet.
        watch: shows progress.

    Returns:
        All rows of the folder, earlier ones included.

    Raises:
        ResultsError: the folder cannot be used; nothing in it was changed.
    """
    jobs = plan.jobs()
    with open_results(
        out, plan, resume=resume, settings=settings, allow_mixed=allow_mixed,
        retry_errors=retry_errors,
    ) as folder:  # fmt: skip
        finished = {row.key for row in folder.rows}
        attempts = [
            Attempt(job, film=_may_be_shown(job, videos)) for job in jobs if job.key not in finished
        ]
        with (
            watch(len(jobs), tuple(folder.rows)) as seen,
            closing(executor.execute(work, attempts)) as played,
        ):
            for row, video in played:
                if video and not (videos == "failures" and row.success):
                    save_video(out, row.key, video)
                folder.append(row)
                seen(row)
        return folder.rows
