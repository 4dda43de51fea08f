"""What is evaluated: versioned suites and the seed of every episode."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from benchmarks.conditions import DEFAULT, Condition, TaskSpec
from icd_envs.errors import InvalidOptionError, unknown_name

_CABLES: Final = ("charging", "ethernet", "rope")
CABLE: Final = "ICDCableRouting-v0"
NOTEBOOK: Final = "ICDNotebookFolding-v0"
CABLE_ADAPTATION: Final = "ICDCableRoutingAdaptation-v0"
NOTEBOOK_ADAPTATION: Final = "ICDNotebookFoldingAdaptation-v0"

TASKS: Final = tuple(map(TaskSpec, (CABLE, NOTEBOOK, CABLE_ADAPTATION, NOTEBOOK_ADAPTATION)))
PAPER_TASKS: Final = tuple(map(TaskSpec, (CABLE, NOTEBOOK, CABLE_ADAPTATION)))

CONTACT_GOALS: Final = Condition("contact goals", (("goals", "contact"),))
_PARTIAL: Final = Condition("partial view", (("obs_mode", "partial"),))
_ACTION_NOISE: Final = Condition("action noise", action_noise=0.2)
_OBSERVATION_NOISE: Final = Condition("observation noise", observation_noise=0.005)
_MISMATCH: Final = Condition(
    "model mismatch", planner_stiffness=2.0, planner_mass=0.7, planner_friction=0.5
)
ROBUST_TASKS: Final = tuple(
    TaskSpec(env, condition)
    for env, conditions in {
        CABLE: (
            DEFAULT,
            CONTACT_GOALS,
            _PARTIAL,
            _ACTION_NOISE,
            _OBSERVATION_NOISE,
            _MISMATCH,
            *(Condition(f"{cable} cable", (("cable", cable),)) for cable in _CABLES),
            Condition("1 fixture", (("num_fixtures", 1),)),
            Condition("3 fixtures", (("num_fixtures", 3),)),
            Condition("4 fixtures", (("num_fixtures", 4),)),
        ),
        NOTEBOOK: (DEFAULT, _PARTIAL, _ACTION_NOISE, _OBSERVATION_NOISE, _MISMATCH),
    }.items()
    for condition in conditions
)
"""Each beside the default in the same scenes, so that the price of a condition is seen in pairs.

An action noise of 0.2 is 6 mm per step. An observation noise of 5 mm is more than a depth
camera's, less than the width of a throat. Cable and number of clips change the scenes too.
"""
CONTACT_TASKS: Final = (TaskSpec(CABLE, CONTACT_GOALS), TaskSpec(CABLE_ADAPTATION, CONTACT_GOALS))
"""Where one scene has many goals, so that who ignores the goal fails; in the adaptation task the
goal is of another scene as well."""
_TRAINING: Final = Condition("training scenes", (("split", "train"),))
VALIDATION_TASKS: Final = tuple(TaskSpec(task.env, _TRAINING) for task in TASKS)
"""To tune and to choose on: no test scene, and none of the demonstrations either."""
VALIDATION_SEED: Final = 1_000_000
"""Demonstrations have a base seed of 0, unless their user wants another one."""


@dataclass(frozen=True)
class Suite:
    """A fixed set of episodes; whatever changes it bumps ``version``.

    Attributes:
        name: what users call it.
        version: counts the changes of its tasks or episodes.
        tasks: environments and conditions.
        episodes: test cases per task.
        repeats: episodes per test case, with other seeds of the agent.
        seed: base seed, unless another is asked for.
    """

    name: str
    version: int
    tasks: tuple[TaskSpec, ...]
    episodes: int
    repeats: int = 1
    seed: int = 0

    @property
    def description(self) -> str:
        """How much it is."""
        seeds = "" if self.repeats == 1 else f" x {self.repeats} seeds"
        return f"{len(self.tasks)} tasks x {self.episodes} cases{seeds}"

    @property
    def title(self) -> str:
        """Name and version."""
        return f"{self.name} v{self.version}"


SUITES: Final[Mapping[str, Suite]] = MappingProxyType(
    {
        suite.name: suite
        for suite in (
            Suite("smoke", version=2, tasks=TASKS, episodes=1),
            Suite("quick", version=2, tasks=TASKS, episodes=5),
            Suite("paper", version=1, tasks=PAPER_TASKS, episodes=10, repeats=2),
            Suite("full", version=1, tasks=TASKS, episodes=100),
            Suite("robust", version=3, tasks=ROBUST_TASKS, episodes=20),
            Suite("contact", version=2, tasks=CONTACT_TASKS, episodes=20),
            Suite(
                "validation",
                version=1,
                tasks=VALIDATION_TASKS,
                episodes=20,
                seed=VALIDATION_SEED,
            ),
        )
    }
)


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


def agent_seed(seed: int, repeat: int) -> int:
    """Seed of the agent in one episode: the scene's own, but for repeats.

    Args:
        seed: from ``episode_seed``.
        repeat: how often the agent has met this case before, >= 0.
    """
    if repeat == 0:
        return seed
    return int(np.random.SeedSequence([seed, repeat]).generate_state(1)[0]) >> 1
