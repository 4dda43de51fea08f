"""The contract of an agent, on agents that break one clause each."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import agent_check
from benchmarks.agent_check import check_agent
from benchmarks.attempt import Settings
from benchmarks.executors import InProcess, Local
from tests.bench import toy


class Stateless(toy.Straight):
    """Acts at any time."""

    def reset(self, episode: object, seed: int) -> None:
        pass


class Vague(toy.Straight):
    needs_simulator = "maybe"


class Eager(toy.Straight):
    episode = None

    def act(self, observation: dict[str, np.ndarray]) -> object:
        return super().act(observation) if self.episode else "not yet"


class Resetless(toy.Straight):
    def reset(self, episode: object, seed: int) -> None:
        raise KeyError("episode")


class Wordy(toy.Straight):
    def act(self, observation: dict[str, np.ndarray]) -> object:
        return ["left", "right", "up"]


class Wild(toy.Straight):
    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return 2.0 * super().act(observation)


class Remembering(toy.Straight):
    """Forgets to forget."""

    acts = 0

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        self.acts += 1
        return super().act(observation) / self.acts


class Personal(toy.Straight):
    """Every instance is different."""

    made = 0

    def __init__(self) -> None:
        Personal.made += 1
        self.factor = 1.0 / Personal.made

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return super().act(observation) * self.factor


class Once(toy.Straight):
    """Has one episode in it."""

    used = False

    def reset(self, episode: object, seed: int) -> None:
        super().reset(episode, seed)
        if self.used:
            raise RuntimeError("not again")
        self.used = True


def problems(name: str) -> dict[str, str]:
    found = check_agent(name, toy.ENV, InProcess(), Settings())
    return {check: problem for check, problem in found if problem}


@pytest.mark.parametrize("agent", [toy.Straight, toy.Planner, Stateless])
def test_sound_agent_passes_every_check(agent: type) -> None:
    found = check_agent(f"{agent.__module__}:{agent.__name__}", toy.ENV, InProcess(), Settings())
    assert len(found) == 12
    assert [finding for finding in found if finding.problem] == []


@pytest.mark.parametrize(
    ("agent", "check", "problem"),
    [
        (toy.Unready, agent_check.MADE, "a class with reset"),
        (Vague, agent_check.FLAGS, "maybe"),
        (Eager, agent_check.EARLY, "not yet"),
        (Resetless, agent_check.RESET, "KeyError: 'episode'"),
        (toy.Raiser, agent_check.ACT, "ZeroDivisionError"),
        (toy.Quitter, agent_check.ACT, "SystemExit"),
        (toy.Vandal, agent_check.MUTATION, "act wrote into observation, desired_goal"),
        (Wordy, agent_check.NUMBERS, "left"),
        (toy.Flat, agent_check.SHAPE, r"(2,), not (3,)"),
        (toy.Nan, agent_check.FINITE, "nan"),
        (Wild, agent_check.BOUNDS, "would be clipped"),
        (Remembering, agent_check.REPEAT, "they differ"),
        (Personal, agent_check.FRESH, "they differ"),
        (Once, agent_check.RESET, "RuntimeError: not again"),
    ],
)
def test_broken_clause_is_named(agent: type, check: str, problem: str) -> None:
    found = problems(f"{agent.__module__}:{agent.__name__}")
    assert problem in found[check]
    assert set(found) <= {check, agent_check.EARLY, agent_check.FRESH}


def test_agent_that_dies_or_hangs_is_told_from_its_checker() -> None:
    settings = Settings(act_seconds=0.5)
    for agent, reason in ((toy.Killed, "signal 9"), (toy.Sleeper, "time budget of 0.5 s")):
        (finding,) = check_agent(toy.spec(agent), toy.ENV, Local(), settings)
        assert finding.check in (agent_check.ACT, agent_check.EARLY)
        assert reason in finding.problem
