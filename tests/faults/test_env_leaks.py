"""Environments that are made, reset and closed many times leave nothing behind."""

from __future__ import annotations

import resource
import sys
from pathlib import Path

import numpy as np
import pytest

from icd_envs.tasks.env import ContactEnv
from tests.envs.making import CABLE, make

PROCESS = Path("/proc/self")


def count(kind: str) -> int:
    """Open files (``fd``) or threads (``task``) of this process; 0 where the system hides them."""
    folder = PROCESS / kind
    return len(list(folder.iterdir())) if folder.exists() else 0


def use(env: ContactEnv[object], seed: int) -> None:
    """One short episode with a planner's simulator."""
    env.reset(seed=seed)
    simulator = env.episode(simulator=True, threads=2).simulator
    assert simulator is not None
    assert not simulator.rollout(env.snapshot(), np.zeros((4, 2, 3))).diverged.any()


def test_threads_and_files_end_with_the_environment() -> None:
    use(env := make(CABLE), 0)
    env.close()
    before = count("task"), count("fd")
    for seed in range(3):
        env = make(CABLE)
        use(env, seed)
        use(env, seed)
        env.close()
    assert (count("task"), count("fd")) == before


@pytest.mark.slow
def test_memory_does_not_grow_over_hundreds_of_resets() -> None:
    scale = 1024 if sys.platform == "linux" else 1
    env, peaks = make(CABLE), []
    for seed in range(300):
        use(env, seed % 10)
        peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale)
    env.close()
    assert peaks[-1] < 1.05 * peaks[99]
