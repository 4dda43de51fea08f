"""The contract of an agent, tried out for a few steps."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, Final, NamedTuple

import gymnasium as gym
import numpy as np

from benchmarks.attempt import Settings
from benchmarks.beginning import episode_for
from benchmarks.conditions import TaskSpec, make_env
from benchmarks.errors import reason
from benchmarks.executors import Executor, Work
from benchmarks.pulse import Pulse
from benchmarks.registry import Offer, make_agent
from benchmarks.worker import Loss
from icd_envs.api import Agent

STEPS: Final = 8
"""Acts per episode: enough to see whether actions repeat."""

MADE: Final = "can be made"
FLAGS: Final = "needs_simulator and needs_oracle are True or False"
EARLY: Final = "act before reset raises, or acts"
RESET: Final = "reset(episode, seed)"
ACT: Final = "act(observation)"
NUMBERS: Final = "actions are numbers"
SHAPE: Final = "actions have the shape of the action space"
FINITE: Final = "actions are finite"
BOUNDS: Final = "actions are within the action space"
MUTATION: Final = "observations are left alone"
REPEAT: Final = "the same seed gives the same actions, whatever was played before"
FRESH: Final = "a fresh instance gives the same actions"


class Finding(NamedTuple):
    """What came of one check.

    Attributes:
        check: what was looked at.
        problem: what is wrong, or empty.
    """

    check: str
    problem: str


def check_agent(name: str, env_id: str, executor: Executor, settings: Settings) -> list[Finding]:
    """Let an agent play a few steps, in a process of its own.

    Args:
        name: as for ``benchmarks.registry.agent_factory``.
        env_id: environment to play in.
        executor: where the process is.
        settings: what the agent is given.

    Returns:
        The checks that were reached; the first that goes wrong may be the last.
    """
    check = partial(_check, env_id=env_id, settings=settings)
    work = Work(check, _lost, seconds=settings.episode_seconds)
    (findings,) = executor.execute(work, [name])
    return findings


def _lost(name: str, loss: Loss) -> list[Finding]:
    return [Finding(loss.doing, loss.reason)]


class _EndOfTrialError(Exception):
    """Nothing more can be learnt."""


class _Trial:
    """An environment to be played in, and what was found so far."""

    def __init__(self, name: str, env_id: str, pulse: Pulse, settings: Settings) -> None:
        self.found: dict[str, str] = {}
        self._name = name
        self._offer = Offer(env_id, settings.device, settings.trust_pickle)
        self._env = make_env(TaskSpec(env_id))
        self._pulse = pulse
        self._settings = settings

    def run(self) -> None:
        agent = self._make()
        self._look_at_flags(agent)
        self._act_before_reset(agent)
        first, _, again = (self._play(agent, seed) for seed in (1, 2, 1))
        self._expect(REPEAT, np.array_equal(first, again), "they differ")
        fresh = self._play(self._make(), 1)
        self._expect(FRESH, np.array_equal(first, fresh), "they differ")

    def _make(self) -> Agent:
        with self._trying(MADE):
            agent = make_agent(self._name, self._offer)
        return agent

    def _look_at_flags(self, agent: Agent) -> None:
        flags = [getattr(agent, name, False) for name in ("needs_simulator", "needs_oracle")]
        self._expect(FLAGS, all(type(flag) is bool for flag in flags), f"they are {flags}")

    def _act_before_reset(self, agent: Agent) -> None:
        observation, _ = self._env.reset(seed=1)
        budget = self._settings.act_seconds
        with suppress(Exception, SystemExit), self._pulse.limited(EARLY, budget):
            action = np.asarray(agent.act(observation))
            self._expect(EARLY, action.dtype.kind in "fiu", f"it returned {action}")
        self.found.setdefault(EARLY, "")

    def _play(self, agent: Agent, seed: int) -> list[Any]:
        """Play a few steps and return the actions."""
        observation, _ = self._env.reset(seed=seed)
        episode = episode_for(self._env, agent, self._settings.threads)
        with self._trying(RESET):
            agent.reset(episode, seed)
        actions: list[Any] = []
        ended = False
        while not ended and len(actions) < STEPS:
            given = {name: np.array(value) for name, value in observation.items()}
            with self._trying(ACT), self._pulse.limited(ACT, self._settings.act_seconds):
                action = np.array(agent.act(given))  # type: ignore[arg-type]
            touched = [n for n in given if not np.array_equal(given[n], observation[n])]
            self._expect(MUTATION, not touched, f"act wrote into {', '.join(touched)}")
            self._look_at(action)
            actions.append(action)
            observation, _, terminated, truncated, _ = self._env.step(action)
            ended = terminated or truncated
        return actions

    def _look_at(self, action: Any) -> None:  # noqa: ANN401  any array
        space = self._env.action_space
        assert isinstance(space, gym.spaces.Box)
        self._demand(NUMBERS, action.dtype.kind in "fiu", f"act returned {action!r}")
        self._demand(SHAPE, action.shape == space.shape, f"{action.shape}, not {space.shape}")
        self._demand(FINITE, bool(np.isfinite(action).all()), f"act returned {action.tolist()}")
        within = bool((action >= space.low).all() and (action <= space.high).all())
        self._expect(BOUNDS, within, f"{action.tolist()} would be clipped")

    @contextmanager
    def _trying(self, check: str) -> Iterator[None]:
        """Whatever is raised is a problem, and the end."""
        self._pulse.doing = check
        problem = ""
        try:
            yield
        except (Exception, SystemExit) as error:
            problem = reason(error)
        self._demand(check, not problem, problem)

    def _expect(self, check: str, holds: bool, problem: str) -> None:
        """Note how a check went; the first problem counts."""
        self.found[check] = self.found.get(check) or ("" if holds else problem)

    def _demand(self, check: str, holds: bool, problem: str) -> None:
        """The same for what nothing can go on without."""
        self._expect(check, holds, problem)
        if not holds:
            raise _EndOfTrialError


def _check(name: str, pulse: Pulse, env_id: str, settings: Settings) -> list[Finding]:
    trial = _Trial(name, env_id, pulse, settings)
    with suppress(_EndOfTrialError):
        trial.run()
    return [Finding(check, problem) for check, problem in trial.found.items()]
