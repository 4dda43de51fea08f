"""A first look at agents from elsewhere, in processes of their own: importing them may do harm."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final, NamedTuple

from benchmarks.attempt import Settings
from benchmarks.conditions import TaskSpec, make_env
from benchmarks.errors import reason
from benchmarks.executors import Executor, Work
from benchmarks.pulse import Pulse
from benchmarks.registry import AGENTS, Offer, agent_factory, asked, make_agent, origin
from benchmarks.worker import Loss
from icd_envs import ENV_IDS
from icd_envs.errors import IcdError, InvalidOptionError

_SECONDS: Final = 300.0
"""[s] that importing an agent may take."""


class Examined(NamedTuple):
    """What is known of an agent.

    Attributes:
        name: what it was asked for by.
        origin: package and version or file, and a hash of it; empty for an agent of ours.
        problem: why it cannot be used, or empty.
        takes_device: whether its factory asks for the device.
    """

    name: str
    origin: str
    problem: str = ""
    takes_device: bool = False


def examine(
    names: Sequence[str],
    executor: Executor,
    tasks: Sequence[TaskSpec] = (),
    settings: Settings | None = None,
) -> list[Examined]:
    """Import agents, each in a process of its own, and say which of them can be used.

    Args:
        names: as for ``agent_factory``.
        executor: where the processes are.
        tasks: what they must be able to act in: each agent is made for them, and so are those of
            their environments that are not ours.
        settings: what they are given; the usual ones if None.
    """
    settings = settings or Settings()
    look = partial(_look, tasks=tuple(tasks), settings=settings)
    work = Work(look, _lost, group=str, seconds=max(_SECONDS, settings.episode_seconds))
    seen = {examined.name: examined for examined in executor.execute(work, names)}
    return [seen[name] for name in names]


def _look(name: str, pulse: Pulse, tasks: Sequence[TaskSpec], settings: Settings) -> Examined:
    pulse.doing = "importing it"
    try:
        factory = agent_factory(name, trust_pickle=settings.trust_pickle)
    except InvalidOptionError as error:
        return Examined(name, "", str(error))
    try:
        for task in tasks:
            if task.env not in ENV_IDS:
                pulse.doing = f"making {task.env}"
                make_env(task).close()
        for env_id in dict.fromkeys(task.env for task in tasks):
            pulse.doing = f"making it for {env_id}"
            make_agent(name, Offer(env_id, settings.device, settings.trust_pickle))
        pulse.doing = "reading its files"
        found = "" if name in AGENTS else origin(name)
        return Examined(name, found, takes_device="device" in asked(factory))
    except (Exception, SystemExit) as error:
        said = str(error) if isinstance(error, IcdError) else reason(error)
        return Examined(name, "", f"agent {name!r}: {pulse.doing}: {said}")


def _lost(name: str, loss: Loss) -> Examined:
    return Examined(name, "", f"agent {name!r}: {loss.doing or 'importing it'}: {loss.reason}")
