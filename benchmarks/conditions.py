"""What an episode is played in: an environment and the condition it is put under."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final

from icd_envs.errors import InvalidOptionError

if TYPE_CHECKING:
    import gymnasium as gym

Option = bool | int | float | str


@dataclass(frozen=True)
class Condition:
    """How a task differs from its default; episodes of one seed are paired across conditions.

    Attributes:
        name: what rows and tables call it.
        options: arguments of ``gymnasium.make``, by name.
        action_noise: standard deviation added to every action, in units of the action.
        observation_noise: [m] standard deviation added to what is observed of the present state.
        planner_stiffness: bending stiffness of the object in the simulator that planners are
            given, as a multiple of the true one.
        planner_mass: the same of the object's mass.
        planner_friction: the same of all sliding friction.
    """

    name: str = "default"
    options: tuple[tuple[str, Option], ...] = ()
    action_noise: float = 0.0
    observation_noise: float = 0.0
    planner_stiffness: float = 1.0
    planner_mass: float = 1.0
    planner_friction: float = 1.0

    def __post_init__(self) -> None:
        """Refuse values out of range."""
        for field in ("action_noise", "observation_noise"):
            value = getattr(self, field)
            if not (math.isfinite(value) and value >= 0.0):
                raise InvalidOptionError(f"{field} must be finite and >= 0, got {value!r}")
        for field in ("planner_stiffness", "planner_mass", "planner_friction"):
            value = getattr(self, field)
            if not (math.isfinite(value) and value > 0.0):
                raise InvalidOptionError(f"{field} must be finite and > 0, got {value!r}")

    @property
    def description(self) -> str:
        """What differs from the default, in one line."""
        numbers = [
            f"{field.name}={getattr(self, field.name)}"
            for field in fields(self)[2:]
            if getattr(self, field.name) != field.default
        ]
        return ", ".join([*(f"{name}={value!r}" for name, value in self.options), *numbers])

    def record(self) -> dict[str, Any]:
        """As JSON."""
        return {**vars(self), "options": dict(self.options)}


DEFAULT: Final = Condition()


def parse_options(texts: Sequence[str]) -> tuple[tuple[str, int | str], ...]:
    """Options of a task as they are given on the command line, each as ``name=value``.

    Raises:
        InvalidOptionError: one is no such text; the task itself says which names it knows.
    """
    return tuple(map(_parse_option, texts))


def _parse_option(text: str) -> tuple[str, int | str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise InvalidOptionError(f"--option must be name=value, got {text!r}: e.g. goals=contact")
    return name, int(value) if value.isdecimal() else value


@dataclass(frozen=True)
class TaskSpec:
    """One line of a suite.

    Attributes:
        env: id of the environment.
        condition: what it is put under.
    """

    env: str
    condition: Condition = DEFAULT

    @property
    def key(self) -> tuple[str, str]:
        """How rows name it."""
        return (self.env, self.condition.name)

    def record(self) -> dict[str, Any]:
        """As JSON."""
        return {"env": self.env, "condition": self.condition.record()}


def task_title(env: str, condition: str) -> str:
    """How tables call a task."""
    return env if condition == DEFAULT.name else f"{env}, {condition}"


def task_from_record(record: Mapping[str, Any]) -> TaskSpec:
    """The reverse of ``TaskSpec.record``.

    Raises:
        KeyError, TypeError, InvalidOptionError: it is no such record.
    """
    condition = dict(record["condition"])
    condition["options"] = tuple(condition["options"].items())
    return TaskSpec(record["env"], Condition(**condition))


def make_env(task: TaskSpec) -> gym.Env[Any, Any]:
    """Make the environment of a task, with test scenes unless its condition wants others.

    Raises:
        InvalidOptionError: on an option that the environment does not take.
    """
    import gymnasium as gym

    import icd_envs  # noqa: F401  registers our ids
    from icd_envs.wrappers import MismatchedPlanner, NoisyActions, NoisyObservations

    condition = task.condition
    options: dict[str, Any] = {"split": "test", **dict(condition.options)}
    env: gym.Env[Any, Any] = gym.make(task.env, disable_env_checker=True, **options)
    planner = (condition.planner_stiffness, condition.planner_mass, condition.planner_friction)
    if planner != (1.0, 1.0, 1.0):
        env = MismatchedPlanner(env, *planner)
    if condition.action_noise > 0.0:
        env = NoisyActions(env, condition.action_noise)
    if condition.observation_noise > 0.0:
        env = NoisyObservations(env, condition.observation_noise)
    return env
