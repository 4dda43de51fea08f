"""One agent in one environment, step by step. Draws nothing and waits for nobody."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.beginning import begin, episode_for
from benchmarks.conditions import Condition, Option, TaskSpec, make_env
from benchmarks.errors import blaming, reason
from benchmarks.plan import Job
from benchmarks.registry import Offer, make_agent
from benchmarks.suites import episode_seed
from icd_envs.api import Agent, Float32Array, FloatArray, Observation, PlanView, Simulator
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.env import ContactEnv


@dataclass(frozen=True)
class Future:
    """What comes of an agent's plan if nothing changes it.

    Attributes:
        path: (H, 3) [m] gripper positions.
        end: (N, 3) [m] object cloud at their end.
    """

    path: Float32Array
    end: Float32Array


@dataclass(frozen=True)
class Moment:
    """What there is to see after one step.

    Attributes:
        episode: index of the episode, as in ``icd-bench run``.
        seed: of scene and agent.
        step: control steps taken.
        budget: control steps before the episode is truncated.
        observation: what the agent sees next.
        success: whether the goal's contacts hold now.
        complete_rate: share of the task's parts done.
        end: why the episode has ended; empty while it goes on.
        plan: what the agent was thinking when it took the step, if it says so.
        future: where its plan leads, if it has one.
    """

    episode: int
    seed: int
    step: int
    budget: int
    observation: Observation
    success: bool
    complete_rate: float
    end: str = ""
    plan: PlanView | None = None
    future: Future | None = None


class Session:
    """Episodes of a benchmark, one step at a time.

    Attributes:
        agent_name: as given.
        env: the environment, for those who draw it.
        errors: episodes that ended because agent or environment raised.
    """

    def __init__(
        self,
        agent: str,
        env_id: str,
        *,
        options: tuple[tuple[str, Option], ...] = (),
        seed: int = 0,
        threads: int = 1,
        trust_pickle: bool = False,
    ) -> None:
        """Make agent and environment.

        Args:
            agent: name or ``module:attr``.
            env_id: id of one of this project's environments.
            options: arguments of ``gymnasium.make``, by name.
            seed: base seed, as of ``icd-bench run``: the same episodes.
            threads: for the agent's simulator.
            trust_pickle: whether the agent may be unpickled.

        Raises:
            InvalidOptionError: unknown agent or option, or an environment of another kind.
            AgentFailedError: making the agent raised.
        """
        self.agent_name = agent
        with blaming(agent):
            self._agent: Agent = make_agent(agent, Offer(env_id, trust_pickle=trust_pickle))
        made = make_env(TaskSpec(env_id, Condition("watched", options))).unwrapped
        if not isinstance(made, ContactEnv):
            made.close()
            raise InvalidOptionError(
                f"env {env_id!r} is a {type(made).__name__}: only this project's environments can "
                "be watched"
            )
        self.env: ContactEnv[Any] = made
        self._env_id, self._base_seed, self._threads = env_id, seed, threads
        self.errors = 0

    def begin(self, episode: int) -> Moment:
        """Draw the scene of an episode and tell the agent.

        Raises:
            SceneGenerationError: if no solvable scene was found.
        """
        seed = episode_seed(self._base_seed, self._env_id, episode)
        job = Job(self.agent_name, self._env_id, episode, seed)
        observation, info = self.env.reset(seed=seed)
        told = episode_for(self.env, self._agent, self._threads)
        self._simulator: Simulator | None = self.env.episode(simulator=True).simulator
        moment = Moment(
            episode, seed, 0, told.max_steps, observation, info["is_success"], info["complete_rate"]
        )
        try:
            begin(self._agent, told, job.agent_seed)
        except (Exception, SystemExit) as error:
            moment = self._broken(moment, error)
        self._moment = moment
        return moment

    def advance(self) -> Moment:
        """Let the agent take one step; once the episode has ended, nothing happens."""
        if not self._moment.end:
            try:
                self._moment = self._step(self._moment)
            except (Exception, SystemExit) as error:
                self._moment = self._broken(self._moment, error)
        return self._moment

    def close(self) -> None:
        """Free the environment."""
        self.env.close()

    def _step(self, before: Moment) -> Moment:
        given = {name: np.array(value) for name, value in before.observation.items()}
        action = self._agent.act(given)  # type: ignore[arg-type]
        ask = getattr(self._agent, "plan_view", None)
        plan = None if ask is None else ask()
        if not (plan is None or isinstance(plan, PlanView)):
            raise InvalidOptionError(
                f"plan_view() returned {type(plan).__name__}: return icd_envs.api.PlanView or None"
            )
        future = None
        if plan is not None and plan.actions is not None:
            future = self._follow(plan.actions)
        observation, _, terminated, truncated, info = self.env.step(action)
        end = ""
        if terminated:
            end = "success" if info["is_success"] else "the physics diverged"
        elif truncated:
            end = "out of time"
        return replace(
            before,
            step=before.step + 1,
            observation=observation,
            success=info["is_success"],
            complete_rate=info["complete_rate"],
            end=end,
            plan=plan,
            future=future,
        )

    def _follow(self, actions: FloatArray) -> Future:
        assert self._simulator is not None
        rollout = self._simulator.rollout(self._simulator.snapshot(), actions[None])
        return Future(rollout.gripper[0], rollout.points[0, -1])

    def _broken(self, moment: Moment, error: BaseException) -> Moment:
        self.errors += 1
        return replace(moment, end=f"error: {reason(error)}", plan=None, future=None)
