"""Success must hold for ten steps in a row: a step without it begins the count anew."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest

from icd_envs.api import BoolArray
from icd_envs.tasks.base import HOLD_STEPS, Demonstration, run_expert
from icd_envs.tasks.notebook_folding import NotebookFolding
from tests.envs.making import make

NOTEBOOK = "ICDNotebookFolding-v0"
LOST = [True] * (HOLD_STEPS - 1) + [False]
"""Success, lost one step too early."""


class Still:
    """An expert that waits and is never done."""

    done = False

    def act(self, gripper: np.ndarray, points: np.ndarray) -> np.ndarray:
        return np.zeros(3)


def script(monkeypatch: pytest.MonkeyPatch, method: str, told: list[bool]) -> None:
    """Let a method of the task answer as told, then with False for ever."""
    answers: Iterator[bool] = itertools.chain(told, itertools.repeat(False))

    def answer(self: NotebookFolding, *args: object) -> BoolArray:
        return np.full((1, 1) if method == "matches" else 1, next(answers))

    monkeypatch.setattr(NotebookFolding, method, answer)


def demonstrate(told: list[bool], monkeypatch: pytest.MonkeyPatch) -> Demonstration:
    """What becomes of 25 steps of an expert whose success is told for the start and each step."""
    task = NotebookFolding()
    scene = task.draw_scenes(np.random.default_rng(0)).scene
    script(monkeypatch, "solved", told)
    return run_expert(task, scene, task.make_plant(scene), Still(), 25)


def test_success_ends_an_episode_once_it_has_held_without_a_break(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    env = make(NOTEBOOK)
    env.reset(seed=0)
    script(monkeypatch, "matches", LOST + [True] * HOLD_STEPS)
    ends: list[bool] = []
    held: list[int] = []
    for _ in range(2 * HOLD_STEPS):
        _, _, terminated, _, info = env.step(np.zeros(3))
        ends.append(terminated)
        held.append(env.snapshot().held)
        assert info["is_success"] == (held[-1] > 0)
    assert held == [*range(1, HOLD_STEPS), 0, *range(1, HOLD_STEPS + 1)]
    assert ends == [False] * (2 * HOLD_STEPS - 1) + [True]
    env.close()


def test_expert_goes_on_until_success_has_held_without_a_break(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = demonstrate([False, *LOST, *[True] * HOLD_STEPS], monkeypatch)
    assert run.success
    assert run.steps == 2 * HOLD_STEPS


def test_expert_that_loses_success_twice_has_not_succeeded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = demonstrate([False, *LOST, *LOST], monkeypatch)
    assert not run.success
    assert run.steps == 25
