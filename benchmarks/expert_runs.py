"""Episodes of the scripted expert on raw scenes, none rejected, as rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Literal

from benchmarks.plan import Job
from benchmarks.rows import Row, error_row
from benchmarks.runner import Work


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

    def work(self, workers: int) -> Work:
        """What does one of its jobs."""
        return partial(run_expert, split=self.split, noisy=self.noisy)


def run_expert(job: Job, split: Literal["train", "test"], noisy: bool) -> Row:
    """Run the expert once; an exception becomes a row of status "error"."""
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
