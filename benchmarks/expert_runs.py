"""Rows of the scripted expert, or of no agent at all: what gates need besides agents."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Literal, NamedTuple

from benchmarks.attempt import Attempt, Played
from benchmarks.conditions import DEFAULT, Condition
from benchmarks.executors import Work
from benchmarks.plan import Job
from benchmarks.pulse import Pulse
from benchmarks.rows import Row, error_row
from benchmarks.runner import Episodes, lost


class Outcome(NamedTuple):
    """How an episode ended."""

    success: bool
    complete: float
    steps: int
    diverged: bool


@dataclass(frozen=True)
class ExpertRuns:
    """The scripted expert on raw scenes, none rejected.

    Attributes:
        agent: name in rows and folders.
        split: stream of scenes.
        noisy: with the noise and detours of the training data.
        episodes: how many.
        condition: what the task is put under.
    """

    agent: str
    split: Literal["train", "test"]
    noisy: bool
    episodes: int
    condition: Condition = DEFAULT

    def work(self, threads: int) -> Episodes:
        """What does one of its jobs; the expert plans nothing and needs one thread."""
        play = partial(_demonstrate, split=self.split, noisy=self.noisy)
        return Work(partial(play_row, play=play), lost)


@dataclass(frozen=True)
class CopiedGoals:
    """The goal's object cloud put into the present scene as it is, wherever it was specified.

    Attributes:
        agent: name in rows and folders.
        episodes: how many.
        condition: what the task is put under.
    """

    agent: str
    episodes: int
    condition: Condition = DEFAULT

    def work(self, threads: int) -> Episodes:
        """What does one of its jobs."""
        return Work(partial(play_row, play=_copy_goal), lost)


@dataclass(frozen=True)
class RoutesAll:
    """An expert that passes every clip's throat, whatever a contact goal asks for.

    It stands for agents that do not look at their goal; as in the environment, what it has done at
    the end counts.

    Attributes:
        agent: name in rows and folders.
        episodes: how many.
        condition: what the task is put under.
    """

    agent: str
    episodes: int
    condition: Condition = DEFAULT

    def work(self, threads: int) -> Episodes:
        """What does one of its jobs."""
        return Work(partial(play_row, play=_route_all), lost)


def play_row(attempt: Attempt, pulse: Pulse, play: Callable[[Job], Outcome]) -> Played:
    """Play once; an exception becomes a row of status "error"."""
    return Played(_row(attempt.job, play))


def _row(job: Job, play: Callable[[Job], Outcome]) -> Row:
    start = perf_counter()
    try:
        outcome = play(job)
    except Exception as error:
        return error_row(
            job,
            f"{job.agent}: {type(error).__name__}: {error}",
            seconds=perf_counter() - start,
            privileged="oracle",
        )
    return Row(
        agent=job.agent,
        env=job.env,
        index=job.index,
        seed=job.seed,
        condition=job.condition.name,
        repeat=job.repeat,
        status="ok",
        success=outcome.success,
        complete=outcome.complete,
        steps=outcome.steps,
        return_=0.0,
        diverged=outcome.diverged,
        message="",
        seconds=perf_counter() - start,
        act_seconds=0.0,
        privileged="oracle",
    )


def _demonstrate(job: Job, split: Literal["train", "test"], noisy: bool) -> Outcome:
    from icd_envs.demonstrations import demonstrate

    shown = demonstrate(job.env, seed=job.seed, split=split, noisy=noisy)
    return Outcome(shown.success, shown.complete_rate, shown.steps, shown.diverged)


def _copy_goal(job: Job) -> Outcome:
    from icd_envs.demonstrations import find_task
    from icd_envs.tasks.problem import draw_problem, matched_parts, scene_rng

    task = find_task(job.env)
    problem = draw_problem(task, scene_rng("test", job.seed), job.seed)
    matched = matched_parts(task, problem, problem.goal)
    return Outcome(bool(matched.all()), float(matched.mean()), 0, False)


def _route_all(job: Job) -> Outcome:
    from icd_envs.demonstrations import find_task
    from icd_envs.scenes.cable_routing import ROUTED
    from icd_envs.tasks.base import run_expert
    from icd_envs.tasks.problem import draw_problem, matched_parts, scene_rng

    task = find_task(job.env, dict(job.condition.options))
    problem = draw_problem(task, scene_rng("test", job.seed), job.seed)
    routed = replace(problem.scene, contacts=ROUTED * len(problem.scene.clips))
    shown = run_expert(task, routed, problem.plant, task.make_expert(routed))
    matched = matched_parts(task, problem, shown.points[-1])
    return Outcome(bool(matched.all()), float(matched.mean()), shown.steps, shown.diverged)
