"""What ``icd-bench run`` does: look at everything first, then run."""

from __future__ import annotations

from pathlib import Path

from benchmarks import registry, runner
from benchmarks.attempt import Settings
from benchmarks.examination import examine
from benchmarks.executors import Executor
from benchmarks.plan import Plan
from benchmarks.rows import Row
from benchmarks.runner import Watch
from icd_envs.errors import InvalidOptionError


def run_plan(
    plan: Plan,
    out: Path,
    executor: Executor,
    settings: Settings,
    *,
    resume: bool,
    allow_mixed: bool,
    watch: Watch,
) -> list[Row]:
    """Run agents; see ``benchmarks.runner.run`` for the arguments.

    Raises:
        InvalidOptionError: an environment or agent cannot be used; nothing was run.
        ResultsError: the folder cannot be used; nothing in it was changed.
    """
    for env_id in plan.envs:
        registry.check_env_id(env_id)
    foreign = [name for name in plan.agents if name not in registry.AGENTS]
    examined = examine(foreign, executor, trust_pickle=settings.trust_pickle)
    for problem in (agent.problem for agent in examined if agent.problem):
        raise InvalidOptionError(problem)
    origins = {f"agent {agent.name}": agent.origin for agent in examined}
    return runner.run(
        plan,
        out,
        runner.episodes(settings),
        executor,
        settings=settings.record() | origins,
        resume=resume,
        allow_mixed=allow_mixed,
        watch=watch,
    )
