"""Agents that die, hang, cheat or meddle: each gets its own rows, the others never notice."""

from __future__ import annotations

import dataclasses
import os
import time
from pathlib import Path

import pytest

from benchmarks.executors import Executor, InProcess, Local
from benchmarks.rows import Row
from tests.bench import toy
from tests.bench.making import LIMITS, run_toys

QUICK = dataclasses.replace(LIMITS, act_seconds=0.5)
BAD = (
    toy.Killer, toy.Killed, toy.Crasher, toy.Raiser, toy.Quitter, toy.Nan, toy.Flat, toy.Vandal,
    toy.Meddler, toy.Unready,
)  # fmt: skip
GOOD = (toy.Homebody, toy.Gambler)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    """Rows of the good without the bad."""
    return run_toys(tmp_path_factory.mktemp("alone"), *GOOD, executor=Local(1))


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    """Rows of all, the bad ones first."""
    return run_toys(tmp_path_factory.mktemp("all"), *BAD, *GOOD, executor=Local(2), limits=QUICK)


def of(agent: type, rows: list[Row]) -> list[Row]:
    return [row for row in rows if row.agent == toy.spec(agent)]


@pytest.mark.parametrize("agent", GOOD)
def test_good_agents_do_not_notice_the_bad(
    agent: type, alone: list[Row], together: list[Row]
) -> None:
    assert of(agent, together) == of(agent, alone)
    assert [row.status for row in of(agent, alone)] == ["ok"] * 4


@pytest.mark.parametrize(
    ("agent", "reason"),
    [
        (toy.Killer, "act, step 0: worker died (exit status 11)"),
        (toy.Killed, "act, step 0: worker died (signal 9)"),
        (toy.Crasher, "act, step 0: worker died (signal 11)"),
        (toy.Raiser, "act, step 0: ZeroDivisionError"),
    ],
)
def test_only_the_episodes_in_which_it_happens_are_errors(
    agent: type, reason: str, together: list[Row]
) -> None:
    rows = of(agent, together)
    assert {row.seed % 2 for row in rows} == {0, 1}, "the test needs both kinds of episode"
    for row in rows:
        assert row.status == ("error" if row.seed % 2 else "ok")
        assert row.message.startswith(reason if row.seed % 2 else "")


@pytest.mark.parametrize(
    ("agent", "status", "reason"),
    [
        (toy.Quitter, "error", "SystemExit: 4"),
        (toy.Nan, "error", "InvalidActionError"),
        (toy.Flat, "error", "InvalidActionError: action must be (3,)"),
        (toy.Unready, "error", "a class with reset(episode, seed)"),
        (toy.Vandal, "ok", ""),
        (toy.Meddler, "ok", ""),
    ],
)
def test_what_an_agent_did_is_told_in_its_rows(
    agent: type, status: str, reason: str, together: list[Row]
) -> None:
    rows = of(agent, together)
    assert len(rows) == 4
    for row in rows:
        assert row.status == status
        assert reason in row.message


@pytest.mark.parametrize("executor", [InProcess(), Local(1), Local(3)])
def test_agents_that_draw_from_global_generators_repeat_all_the_same(
    executor: Executor, alone: list[Row], tmp_path: Path
) -> None:
    rows = run_toys(tmp_path, toy.Straight, toy.Gambler, executor=executor)
    assert of(toy.Gambler, rows) == of(toy.Gambler, alone)


def test_agent_that_sleeps_for_ever_is_ended_with_all_it_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(toy.LOCKS, str(tmp_path))
    rows = run_toys(
        tmp_path / "out", toy.Parent, toy.Straight, n=1, executor=Local(1), limits=QUICK
    )
    parent, straight = of(toy.Parent, rows), of(toy.Straight, rows)
    assert parent[0].message == "act, step 0: over its time budget of 0.5 s"
    assert straight[0].status == "ok"
    assert is_gone(int((tmp_path / "child").read_text()))


def test_episode_has_a_time_budget_of_its_own(tmp_path: Path) -> None:
    limits = dataclasses.replace(LIMITS, episode_seconds=2.0)
    (row,) = run_toys(tmp_path, toy.Sleeper, n=1, executor=Local(1), limits=limits)
    assert row.message == "act, step 0: over its time budget of 2 s in all"


def is_gone(pid: int) -> bool:
    """Whether a process ends, or at least is a zombie, within a second."""
    for _ in range(100):
        stat = Path(f"/proc/{pid}/stat")
        if not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.01)
    os.kill(pid, 9)
    return False
