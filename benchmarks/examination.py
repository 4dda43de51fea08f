"""A first look at agents from elsewhere, in processes of their own: importing them may do harm."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final, NamedTuple

from benchmarks.executors import Executor, Work
from benchmarks.pulse import Pulse
from benchmarks.registry import agent_factory, origin
from benchmarks.worker import Loss
from icd_envs.errors import InvalidOptionError

_SECONDS: Final = 300.0
"""[s] that an import may take."""


class Examined(NamedTuple):
    """What is known of an agent.

    Attributes:
        name: what it was asked for by.
        origin: package and version or file, and a hash of it.
        problem: why it cannot be used, or empty.
    """

    name: str
    origin: str
    problem: str = ""


def examine(
    names: Sequence[str], executor: Executor, *, trust_pickle: bool = False
) -> list[Examined]:
    """Import agents, each in a process of its own, and say which of them can be used.

    Args:
        names: as for ``agent_factory``.
        executor: where the processes are.
        trust_pickle: whether files may be unpickled.
    """
    work = Work(partial(_look, trust_pickle=trust_pickle), _lost, group=str, seconds=_SECONDS)
    seen = {examined.name: examined for examined in executor.execute(work, names)}
    return [seen[name] for name in names]


def _look(name: str, pulse: Pulse, trust_pickle: bool) -> Examined:
    try:
        agent_factory(name, trust_pickle=trust_pickle)
        return Examined(name, origin(name))
    except InvalidOptionError as error:
        return Examined(name, "", str(error))


def _lost(name: str, loss: Loss) -> Examined:
    return Examined(name, "", f"agent {name!r}: importing it: {loss.reason}")
