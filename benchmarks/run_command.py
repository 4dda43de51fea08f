"""What ``icd-bench run`` does before it runs."""

from __future__ import annotations

import warnings

from benchmarks import registry
from benchmarks.attempt import Settings
from benchmarks.errors import ResultsWarning
from benchmarks.examination import examine
from benchmarks.executors import Executor
from benchmarks.plan import Plan
from benchmarks.videos import Choice
from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError
from icd_envs.registration import check_env_id
from icd_envs.wrappers.video import check_imageio


def look_first(
    plan: Plan, executor: Executor, settings: Settings, videos: Choice | None
) -> dict[str, str | float]:
    """Make sure that everything is there, before anything is run or written.

    Args:
        plan: what will be run.
        executor: who will run it.
        settings: what agents will be given.
        videos: which episodes will leave a video.

    Returns:
        What decides how episodes end, beside the plan: for ``benchmarks.runner.run``.

    Raises:
        InvalidOptionError: an environment or agent cannot be made, or videos cannot.
    """
    if videos:
        check_imageio()
    for env_id in plan.envs:
        check_env_id(env_id)
    known = settings.device == "cpu" and not set(plan.envs) - set(ENV_IDS)
    names = [name for name in plan.agents if not (known and name in registry.AGENTS)]
    examined = examine(names, executor, plan.tasks, settings)
    for problem in (agent.problem for agent in examined if agent.problem):
        raise InvalidOptionError(problem)
    if settings.device != "cpu":
        for agent in (agent for agent in examined if not agent.takes_device):
            ignored = f"{settings.device} is not used"
            what = f"{agent.name} takes no device and acts on the CPU: {ignored}"
            warnings.warn(what, ResultsWarning, stacklevel=2)
    origins = {f"agent {agent.name}": agent.origin for agent in examined if agent.origin}
    return settings.record() | origins
