"""Which episodes one evaluation consists of."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.suites import episode_seed
from icd_envs.errors import InvalidOptionError

JobKey = tuple[str, str, int]


@dataclass(frozen=True)
class Job:
    """One episode to be run.

    Attributes:
        agent: name of the agent.
        env: id of the environment.
        index: number of the episode.
        seed: seed of scene and agent, from ``episode_seed``.
    """

    agent: str
    env: str
    index: int
    seed: int

    @property
    def key(self) -> JobKey:
        """What makes the job unique in a results folder."""
        return (self.agent, self.env, self.index)


@dataclass(frozen=True)
class Plan:
    """Every agent on the same episodes of every environment.

    Attributes:
        agents: names of the agents.
        envs: ids of the environments.
        episodes: episodes for each agent and environment.
        seed: base seed, >= 0.
    """

    agents: tuple[str, ...]
    envs: tuple[str, ...]
    episodes: int
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse plans without episodes, with negative seeds or repeated names."""
        if self.episodes < 1 or self.seed < 0:
            raise InvalidOptionError(
                f"episodes must be >= 1 and seed >= 0, got episodes={self.episodes!r}, "
                f"seed={self.seed!r}"
            )
        for field, names in (("agents", self.agents), ("envs", self.envs)):
            if not names or len(set(names)) < len(names):
                raise InvalidOptionError(
                    f"{field} must be one or more different names, got {names!r}: name each once"
                )

    def jobs(self) -> list[Job]:
        """All episodes; agents take turns, so that an interrupted run compares like with like."""
        return [
            Job(agent, env, index, episode_seed(self.seed, env, index))
            for index in range(self.episodes)
            for env in self.envs
            for agent in self.agents
        ]

    def extends(self, other: Plan) -> bool:
        """Whether every episode of ``other`` is also one of this plan."""
        return (
            self.seed == other.seed
            and self.episodes >= other.episodes
            and set(self.agents) >= set(other.agents)
            and set(self.envs) >= set(other.envs)
        )
