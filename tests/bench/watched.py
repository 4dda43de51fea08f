"""Agents worth watching, importable by name, and a view that remembers."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.watch.session import Moment
from icd_envs.api import Episode, Observation, PlanView
from icd_envs.tasks.env import ContactEnv

CABLE = "ICDCableRouting-v0"


class Still:
    """Holds still and says nothing."""

    def reset(self, episode: Episode, seed: int) -> None:
        self.seed = seed
        self.steps = 0

    def act(self, observation: Observation) -> np.ndarray:
        self.steps += 1
        return np.zeros(3, np.float32)


class Dreamer(Still):
    """Shows a plan: up, with two subgoals on the way."""

    def act(self, observation: Observation) -> np.ndarray:
        super().act(observation)
        self.cloud = observation["achieved_goal"]
        self.gripper = observation["observation"][:3]
        return np.array([0.0, 0.0, 1.0], np.float32)

    def plan_view(self) -> PlanView:
        up = np.array([0.0, 0.0, 0.1], np.float32)
        path = self.gripper + np.linspace(0, 1, 10)[:, None] * up
        return PlanView(
            status="dreaming",
            subgoals=np.stack([self.cloud, self.cloud + up, self.cloud + 2 * up]),
            subgoal=1,
            actions=np.tile([0.0, 0.0, 1.0], (10, 1)),
            paths=np.stack([path, path + up]),
            ends=np.stack([self.cloud + up, self.cloud + 2 * up]),
        )


class Liar(Still):
    """Shows something else than a plan."""

    def plan_view(self) -> str:
        return "up, up and away"


class Faller(Still):
    """Raises at its third step."""

    def act(self, observation: Observation) -> np.ndarray:
        if self.steps == 2:
            raise ZeroDivisionError("<script>too late</script>")
        return super().act(observation)


class Sleepyhead(Still):
    """Does not even begin."""

    def reset(self, episode: Episode, seed: int) -> None:
        raise SystemExit(3)


def spec(agent: type) -> str:
    """Name by which the benchmark finds an agent of this module."""
    return f"{__name__}:{agent.__name__}"


class Album:
    """A view that keeps what it was shown, open for a number of looks."""

    def __init__(self, looks: int) -> None:
        self.moments: list[Moment] = []
        self.scenes: list[int] = []
        self.looks = looks
        self.closed = False

    @property
    def is_open(self) -> bool:
        self.looks -= 1
        return self.looks >= 0

    def begin(self, env: ContactEnv[Any], moment: Moment) -> None:
        self.scenes.append(moment.episode)
        self.moments.append(moment)

    def show(self, moment: Moment) -> None:
        self.moments.append(moment)

    def close(self) -> None:
        self.closed = True
