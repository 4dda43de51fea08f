"""Which episodes one evaluation consists of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.conditions import DEFAULT, Condition, TaskSpec
from benchmarks.suites import Suite, agent_seed, episode_seed
from icd_envs.errors import InvalidOptionError, unknown_name

JobKey = tuple[str, str, str, int, int]
"""Agent, environment, condition, index and repeat."""


@dataclass(frozen=True)
class Job:
    """One episode to be run.

    Attributes:
        agent: name of the agent.
        env: id of the environment.
        index: number of the test case.
        seed: seed of the scene, from ``episode_seed``.
        condition: what the environment is put under.
        repeat: how often the agent has met this case before.
    """

    agent: str
    env: str
    index: int
    seed: int
    condition: Condition = DEFAULT
    repeat: int = 0

    @property
    def key(self) -> JobKey:
        """What makes the job unique in a results folder."""
        return (self.agent, self.env, self.condition.name, self.index, self.repeat)

    @property
    def task(self) -> TaskSpec:
        """Environment and condition."""
        return TaskSpec(self.env, self.condition)

    @property
    def agent_seed(self) -> int:
        """Seed of the agent."""
        return agent_seed(self.seed, self.repeat)


@dataclass(frozen=True)
class Plan:
    """Every agent on the same episodes of every task.

    Attributes:
        agents: names of the agents.
        tasks: environments and their conditions.
        episodes: test cases for each agent and task.
        seed: base seed, >= 0.
        repeats: episodes for each test case, with other seeds of the agent.
        suite: name and version of the suite, if it is exactly one.
    """

    agents: tuple[str, ...]
    tasks: tuple[TaskSpec, ...]
    episodes: int
    seed: int = 0
    repeats: int = 1
    suite: str = ""

    def __post_init__(self) -> None:
        """Refuse plans without episodes, with negative seeds or repeated names."""
        if self.episodes < 1 or self.repeats < 1 or self.seed < 0:
            raise InvalidOptionError(
                f"episodes and repeats must be >= 1 and seed >= 0, got episodes={self.episodes!r}, "
                f"repeats={self.repeats!r}, seed={self.seed!r}"
            )
        tasks = tuple(task.key for task in self.tasks)
        for field, names in (("agents", self.agents), ("tasks", tasks)):
            if not names or len(set(names)) < len(names):
                raise InvalidOptionError(
                    f"{field} must be one or more different names, got {names!r}: name each once"
                )

    @property
    def envs(self) -> tuple[str, ...]:
        """Ids of the environments, each once."""
        return tuple(dict.fromkeys(task.env for task in self.tasks))

    def jobs(self) -> list[Job]:
        """All episodes; agents take turns, so that an interrupted run compares like with like."""
        return [
            Job(agent, task.env, index, seed, task.condition, repeat)
            for repeat in range(self.repeats)
            for index in range(self.episodes)
            for task in self.tasks
            for seed in [episode_seed(self.seed, task.env, index)]
            for agent in self.agents
        ]

    def extends(self, other: Plan) -> bool:
        """Whether every episode of ``other`` is also one of this plan."""
        return (
            self.seed == other.seed
            and self.episodes >= other.episodes
            and self.repeats >= other.repeats
            and set(self.agents) >= set(other.agents)
            and set(self.tasks) >= set(other.tasks)
        )


def plan_suite(
    suite: Suite,
    agents: Sequence[str],
    *,
    envs: Sequence[str] = (),
    conditions: Sequence[str] = (),
    episodes: int | None = None,
    seed: int | None = None,
) -> Plan:
    """Plan of a suite, or of a part of it.

    Args:
        suite: what to run.
        agents: names; a repeated one counts once.
        envs: only these; one that the suite does not know is taken as it is.
        conditions: only tasks under these; all if empty.
        episodes: test cases for each agent and task, instead of the suite's.
        seed: base seed, instead of the suite's.

    Raises:
        InvalidOptionError: no task is left under one of the conditions.
    """
    tasks = suite.tasks
    if envs:
        known = {env: [task for task in suite.tasks if task.env == env] for env in envs}
        tasks = tuple(task for env, found in known.items() for task in found or [TaskSpec(env)])
    for name in conditions:
        names = sorted({task.condition.name for task in tasks})
        if name not in names:
            raise InvalidOptionError(unknown_name("condition", name, names))
    if conditions:
        tasks = tuple(task for task in tasks if task.condition.name in conditions)
    cases = suite.episodes if episodes is None else episodes
    base = suite.seed if seed is None else seed
    whole = (tasks, cases, base) == (suite.tasks, suite.episodes, suite.seed)
    title = suite.title if whole else ""
    return Plan(tuple(dict.fromkeys(agents)), tasks, cases, base, suite.repeats, title)
