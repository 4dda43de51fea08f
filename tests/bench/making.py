"""Rows and runs for the tests of the benchmark."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from click.testing import Result
from typer.testing import CliRunner

from benchmarks import episode
from benchmarks.attempt import Attempt, Settings
from benchmarks.cli import main
from benchmarks.conditions import Condition, TaskSpec
from benchmarks.executors import Executor, InProcess
from benchmarks.plan import Job, Plan
from benchmarks.pulse import Pulse
from benchmarks.results import open_results
from benchmarks.rows import Row
from benchmarks.runner import episodes, run
from benchmarks.suites import episode_seed
from tests.bench import toy

IN_PROCESS = InProcess()
LIMITS = Settings(act_seconds=20.0, episode_seconds=60.0)


def icd_bench(*arguments: object) -> Result:
    """What the command line does, in this process."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def make_row(**fields: object) -> Row:
    """A row of a finished, unsuccessful episode, but for the fields given."""
    defaults: dict[str, object] = {
        "agent": "a",
        "env": "E-v0",
        "index": 0,
        "seed": 1,
        "status": "ok",
        "success": False,
        "complete": 0.5,
        "steps": 10,
        "return_": -10.0,
        "diverged": False,
        "message": "",
        "seconds": 1.0,
        "act_seconds": 0.1,
        "privileged": "",
    }
    return Row(**{**defaults, **fields})


def play(agent: type, env: str = toy.ENV, seed: int = 2) -> Row:
    """One toy episode in this process."""
    attempt = Attempt(Job(toy.spec(agent), env, index=0, seed=seed))
    return episode.play(attempt, Pulse(), Settings()).row


def run_toys(
    out: Path,
    *agents: type,
    n: int = 4,
    executor: Executor = IN_PROCESS,
    limits: Settings = LIMITS,
    env: str = toy.ENV,
    **options: object,
) -> list[Row]:
    """A run of toy agents, without times, in the plan's order."""
    plan = Plan(tuple(toy.spec(agent) for agent in agents), (TaskSpec(env),), n, seed=7)
    rows = run(plan, out, episodes(limits), executor, settings=limits.record(), **options)
    return in_order(rows)


def in_order(rows: list[Row]) -> list[Row]:
    """Rows without times, sorted."""
    return sorted((row.without_times() for row in rows), key=lambda row: row.key)


def save(folder: Path, rows: Sequence[Row], *, seed: int = 0, repeats: int = 1) -> Path:
    """A results folder with these rows, and a manifest whose plan they are of."""
    agents = tuple(dict.fromkeys(row.agent for row in rows)) or ("a",)
    tasks = dict.fromkeys((row.env, row.condition) for row in rows) or {("E-v0", "default"): None}
    plan = Plan(
        agents,
        tuple(TaskSpec(env, Condition(condition)) for env, condition in tasks),
        1 + max((row.index for row in rows), default=0),
        seed,
        repeats,
    )
    with open_results(folder, plan, resume=False) as results:
        for row in rows:
            results.append(row)
    return folder


def make_rows(agent: str, successes: Sequence[bool], **fields: object) -> list[Row]:
    """Rows of one agent with the seeds of a plan; complete exactly where it succeeds."""
    return [
        make_row(
            agent=agent, index=i, seed=episode_seed(0, str(fields.get("env", "E-v0")), i),
            success=won, complete=float(won), steps=20 + i, **fields,
        )
        for i, won in enumerate(successes)
    ]  # fmt: skip
