"""Episodes of the scripted expert on raw scenes, none rejected, as rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Literal

from benchmarks.attempt import Attempt, Played
from benchmarks.executors import Work
from benchmarks.plan import Job
from benchmarks.pulse import Pulse
from benchmarks.rows import Row, error_row
from benchmarks.runner import Episodes, lost


@dataclass(frozen=True)
class ExpertRuns:
    """Episodes of the scripted expert.

    Attributes:
        agent: name in rows and folders.
        split: stream of scenes.
        noisy: with the noise and detours of the training data.
        episodes: how many.
    """

    agent: str
    split: Literal["train", "test"]
    noisy: bool
    episodes: int

    def work(self, threads: int) -> Episodes:
        """What does one of its jobs; the expert plans nothing and needs one thread."""
        return Work(partial(play_expert, split=self.split, noisy=self.noisy), lost)


def play_expert(
    attempt: Attempt, pulse: Pulse, split: Literal["train", "test"], noisy: bool
) -> Played:
    """Run the expert once; an exception becomes a row of status "error"."""
    return Played(_play(attempt.job, split, noisy))


def _play(job: Job, split: Literal["train", "test"], noisy: bool) -> Row:
    start = perf_counter()
    try:
        from icd_envs.demonstrations import demonstrate

        shown = demonstrate(job.env, seed=job.seed, split=split, noisy=noisy)
        return Row(
            agent=job.agent,
            env=job.env,
            index=job.index,
            seed=job.seed,
            status="ok",
            success=bool(shown.success),
            complete=float(shown.complete_rate),
            steps=int(shown.steps),
            return_=0.0,
            diverged=bool(shown.diverged),
            message="",
            seconds=perf_counter() - start,
            act_seconds=0.0,
            privileged="oracle",
        )
    except Exception as error:
        return error_row(
            job,
            f"expert: {type(error).__name__}: {error}",
            seconds=perf_counter() - start,
            privileged="oracle",
        )
