"""What is evaluated: versioned suites and the seed of every episode."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from icd_envs.errors import InvalidOptionError, unknown_name


@dataclass(frozen=True)
class Suite:
    """A fixed set of episodes; whatever changes it bumps ``version``.

    Attributes:
        name: what users call it.
        version: counts the changes of its tasks or episodes.
        env_ids: the tasks.
        episodes: episodes per task.
    """

    name: str
    version: int
    env_ids: tuple[str, ...]
    episodes: int


SUITES: dict[str, Suite] = {
    suite.name: suite
    for suite in (
        Suite("smoke", version=1, env_ids=("ICDCableRouting-v0",), episodes=1),
        Suite("quick", version=1, env_ids=("ICDCableRouting-v0",), episodes=10),
    )
}


def find_suite(name: str) -> Suite:
    """Return the suite of that name.

    Raises:
        InvalidOptionError: there is none.
    """
    if name not in SUITES:
        raise InvalidOptionError(unknown_name("suite", name, SUITES))
    return SUITES[name]


def episode_seed(base: int, env_id: str, index: int) -> int:
    """Seed of one episode: a function of its arguments only, never of agent, order or worker.

    Args:
        base: seed of the whole evaluation, >= 0.
        env_id: id of the environment; a ``module:`` prefix names the same task and is ignored.
        index: number of the episode, >= 0.

    Returns:
        An integer in [0, 2**31).
    """
    task = zlib.crc32(env_id.rpartition(":")[2].encode())
    return int(np.random.SeedSequence([base, task, index]).generate_state(1)[0]) >> 1
