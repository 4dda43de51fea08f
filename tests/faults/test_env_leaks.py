"""Environments that are made, reset and closed many times leave nothing behind."""

from __future__ import annotations

import contextlib
import resource
import statistics
import sys
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.errors import RenderingUnavailableError
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import make, plant_of

PROCESS = Path("/proc/self")
WARM_UP = 2
"""Uses after which every library has opened what it keeps."""
DRAWN_EVERY = 5
"""Without a GPU a GL context costs more than a reset."""
GROWTH = 1.05
"""Most memory in the end, as a multiple of that in the beginning."""
HOUR = 3600.0
"""[s]"""


class Held(NamedTuple):
    """What this process holds; 0 where the system hides it."""

    files: int
    threads: int
    children: int
    memory: int
    """[bytes] resident, or the most that was."""


def held() -> Held:
    if not PROCESS.exists():
        scale = 1024 if sys.platform == "linux" else 1
        return Held(0, 0, 0, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale)
    children = [path.read_text() for path in PROCESS.glob("task/*/children")]
    pages = int((PROCESS / "statm").read_text().split()[1])
    return Held(
        len(list((PROCESS / "fd").iterdir())),
        len(list((PROCESS / "task").iterdir())),
        sum(len(text.split()) for text in children),
        pages * resource.getpagesize(),
    )


def make_to_draw(env_id: str) -> ContactEnv[Any]:
    return make(env_id, render_mode="rgb_array", width=64, height=48)


def use(env: ContactEnv[Any], seed: int) -> list[weakref.ref[Any]]:
    """A short episode with a planner's simulator, and now and then a picture.

    Returns:
        what belongs to this episode and must go with it.
    """
    env.reset(seed=seed)
    for _ in range(3):
        simulator = env.episode(simulator=True, threads=2).simulator
    assert simulator is not None
    assert not simulator.rollout(env.snapshot(), np.zeros((4, 2, 3))).diverged.any()
    env.step(np.zeros(3))
    if seed % DRAWN_EVERY == 0:
        with contextlib.suppress(RenderingUnavailableError):
            env.render()
    parts = [env._problem, plant_of(env), *env._threads.values(), env._screen._renderer]
    return [weakref.ref(part) for part in parts if part is not None]


def assert_gone(parts: list[weakref.ref[Any]]) -> None:
    assert len(parts) >= 3
    assert [part() for part in parts] == [None] * len(parts)


def over_resets(env_id: str, count: int) -> list[Held]:
    """What is held after each of so many episodes of one environment."""
    env, found = make_to_draw(env_id), []
    parts = use(env, 0)
    for seed in range(1, count + 1):
        old, parts = parts, use(env, seed)
        assert_gone(old)
        found.append(held())
    env.close()
    assert_gone(parts)
    return found


def over_environments(env_id: str, count: int) -> list[Held]:
    """What is held after each of so many environments was closed."""
    found = []
    for seed in range(count):
        env = make_to_draw(env_id)
        parts = use(env, seed)
        env.close()
        assert_gone(parts)
        found.append(held())
    return found


def assert_nothing_left(found: list[Held]) -> None:
    assert len({(now.files, now.threads, now.children) for now in found[WARM_UP:]}) == 1


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_a_few_uses_leave_nothing_behind(env_id: str) -> None:
    assert_nothing_left(over_environments(env_id, 4))
    assert_nothing_left(over_resets(env_id, 5))


@pytest.mark.slow
@pytest.mark.timeout(6 * HOUR)
@pytest.mark.parametrize("env_id", ENV_IDS)
@pytest.mark.parametrize(
    ("over", "count"), [(over_environments, 1_000), (over_resets, 10_000)], ids=["made", "reset"]
)
def test_thousands_of_uses_leave_nothing_behind(
    env_id: str, over: Callable[[str, int], list[Held]], count: int
) -> None:
    found = over(env_id, count)
    assert_nothing_left(found)
    memory, tenth = [now.memory for now in found], count // 10
    begun, ended = (statistics.median(part) for part in (memory[tenth:][:tenth], memory[-tenth:]))
    assert ended < GROWTH * begun
