"""The subgoal tracker: subgoal source + cost space + MPPI + simulator, one agent, many methods."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import get_args

import numpy as np

from icd_agent.chain import (
    CostSpace,
    ReplanningSource,
    Spacing,
    SubgoalChain,
    Subgoals,
    SubgoalSource,
)
from icd_agent.completion import Completion
from icd_agent.mppi.costs import collision_cost, nearest_subgoal_cost, squared_distance
from icd_agent.mppi.planner import MPPI, MPPIConfig
from icd_agent.observed import checked
from icd_agent.options import is_count, is_finite, require
from icd_agent.plan_info import PlanInfo
from icd_envs.api import (
    BoolArray,
    Episode,
    Float32Array,
    Float64Array,
    FloatArray,
    Observation,
    PlanView,
    Rollout,
)
from icd_envs.errors import NOT_BEGUN, EpisodeStateError, InvalidOptionError


@dataclass(frozen=True)
class TrackerConfig:
    """How a chain is followed.

    Attributes:
        threshold: a subgoal is reached within this fraction of the median distance between
            consecutive subgoals.
        spacing: "own" replaces that median by the distance to the subgoal before, if it is larger:
            for spaces in which subgoals lie close together far from contact and far apart near it.
        passed: a subgoal is also reached when this fraction of the way to it from the one before
            is done, however far off the way: generated subgoals are never met exactly. None is
            never.
        window: the cost is the minimum over the next so many subgoals; None is the paper's
            minimum over all that remain, which can jump ahead of a change of contact.
        patience: control steps without a subgoal removed after which one is skipped; None is never.
        replan_every: control steps after which the source is asked for another chain, as it also is
            when patience has run out; None is never. T of the paper. The act at which the first
            chain is made is one of them, the act at which a question is asked is none: with 20,
            acts 21, 42, 63, ... ask, if the first is 1 and patience never runs out.
        collision_weight: lambda_col [cost per metre of penetration and step]. The paper gives no
            value; at 1, one sphere 5 mm deep for one step costs one temperature of the paper.
    """

    threshold: float = 0.35
    spacing: Spacing = "median"
    passed: float | None = None
    window: int | None = None
    patience: int | None = 20
    replan_every: int | None = None
    collision_weight: float = 1.0

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for field in ("threshold", "collision_weight"):
            value = getattr(self, field)
            require(is_finite(value) and value >= 0, field, value, "a finite number >= 0")
        names = get_args(Spacing)
        require(self.spacing in names, "spacing", self.spacing, f"one of {', '.join(names)}")
        done = self.passed
        valid = done is None or (is_finite(done) and 0 < done <= 1)
        require(valid, "passed", done, "None or a fraction of the way in (0, 1]")
        for field in ("window", "patience", "replan_every"):
            value = getattr(self, field)
            require(value is None or is_count(value), field, value, "None or an integer >= 1")


class SubgoalTracker:
    """An agent that follows a chain of subgoals by sampling futures in the simulator.

    Space and source get ready at the first ``act`` of an episode, which may take seconds.
    """

    needs_simulator = True

    def __init__(
        self,
        source: SubgoalSource,
        space: CostSpace,
        mppi: MPPIConfig,
        config: TrackerConfig | None = None,
    ) -> None:
        """Compose an agent.

        Args:
            source: where subgoals come from.
            space: where distances are measured.
            mppi: settings of the planner.
            config: how the chain is followed; the defaults of ``TrackerConfig`` if None.

        Raises:
            InvalidOptionError: ``replan_every`` with a source that cannot be asked again.
        """
        self.needs_oracle = source.needs_oracle
        self.mppi_config = mppi
        self.config = TrackerConfig() if config is None else config
        self.plan_info: PlanInfo | None = None
        if self.config.replan_every is not None and not isinstance(source, ReplanningSource):
            raise InvalidOptionError(
                f"replan_every={self.config.replan_every} cannot be used with "
                f"{type(source).__name__}: it has no again(); give None"
            )
        self._source = source
        self.space = space
        self._episode: Episode | None = None

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode.

        Args:
            episode: must carry a simulator.
            seed: the only source of randomness.

        Raises:
            InvalidOptionError: if what the agent needs is missing from the episode.
        """
        if episode.simulator is None:
            raise InvalidOptionError(_missing("simulator"))
        if self.needs_oracle and episode.oracle is None:
            raise InvalidOptionError(_missing("oracle"))
        self._episode = episode
        self._simulator = episode.simulator
        self._planner = MPPI(self.mppi_config, episode.action_scale)
        self._rng = np.random.default_rng(seed)
        self._completion = Completion(episode.canonical_cloud)
        self._chain: SubgoalChain | None = None
        self._since_asked = 0
        self.plan_info = None

    def act(self, observation: Observation) -> Float32Array:
        """Plan one step.

        Args:
            observation: of the simulator's present state; not changed. Points of the object that a
                partial one hides are guessed from those it shows.

        Returns:
            (3,) in [-1, 1]; zero if no rollout was usable, with the reason in ``plan_info``.

        Raises:
            EpisodeStateError: before ``reset``.
            InvalidObservationError: of other clouds than the episode's, not finite, or at its
                beginning without a point of the scene that is seen.
        """
        if self._episode is None:
            raise EpisodeStateError(NOT_BEGUN)
        observation = checked(observation, len(self._episode.canonical_cloud))
        chain = self._follow(self._episode, self._completion(observation))

        times = [time.perf_counter()]
        actions = self._planner.sample(self._rng)
        times.append(time.perf_counter())
        rollout = self._simulator.rollout(self._simulator.snapshot(), actions)
        times.append(time.perf_counter())
        costs = self._costs(rollout, chain.ahead(), self._episode.gripper_spheres)
        times.append(time.perf_counter())
        update = self._planner.update(actions, costs)
        plan = self._planner.nominal
        action = self._planner.shift().astype(np.float32)
        times.append(time.perf_counter())

        sampling, rolling, costing, updating = np.diff(times).tolist()
        self.plan_info = PlanInfo(
            status=update.status,
            subgoal=chain.index,
            chain_length=len(chain),
            best_cost=update.best_cost,
            mean_cost=update.mean_cost,
            effective_samples=update.effective_samples,
            invalid_samples=update.invalid_samples,
            rollout_seconds=rolling,
            cost_seconds=costing,
            update_seconds=sampling + updating,
            actions=plan,
            subgoals=self._subgoals.clouds,
            rollout=rollout,
            costs=costs,
            steps=self._subgoals.steps,
        )
        return action

    def plan_view(self) -> PlanView | None:
        """What viewers may draw of the last ``act``; None before the first of an episode."""
        return None if self.plan_info is None else self.plan_info.view()

    def _follow(self, episode: Episode, observation: Observation) -> SubgoalChain:
        """The chain as it is now: begun, moved on, or replaced.

        An end that was followed in vain is left for any other chain, but not if the goal must be
        kept: then it may have been reached, and a chain that leads away and back would undo that.
        """
        if self._chain is None:
            self._placed = self.space.place(observation, foreign=episode.foreign_goal)
            subgoals = self._source.chain(episode, observation, self._placed, self._rng)
            self._chain = self._begin(subgoals)
        at_end = self._chain.at_end
        stalled = self._chain.advance(self._placed.here(observation["achieved_goal"]))
        if self._chain.arrived and not episode.ends_on_success:
            return self._chain  # what is left is to stay
        every = self.config.replan_every
        self._since_asked += 1
        if every is not None and (stalled or self._since_asked > every):
            assert isinstance(self._source, ReplanningSource)
            self._since_asked = 0
            in_vain = stalled and at_end and episode.ends_on_success
            index = None if in_vain else self._chain.index
            again = self._source.again(episode, observation, self._placed, self._rng, index)
            if again is not None:
                self._chain = self._begin(again)
        return self._chain

    def _begin(self, subgoals: Subgoals) -> SubgoalChain:
        self._subgoals = subgoals
        config = self.config
        return SubgoalChain(
            subgoals.features,
            config.threshold,
            config.window,
            config.patience,
            config.spacing,
            config.passed,
            subgoals.begin,
        )

    def _costs(self, rollout: Rollout, subgoals: FloatArray, spheres: FloatArray) -> Float64Array:
        """Cost (K,) of each sample; inf where the physics diverged, or tells no places."""
        features = self._placed.here(rollout.points)
        costs = nearest_subgoal_cost(squared_distance(features, subgoals))
        costs += collision_cost(
            rollout.gripper, spheres, self._simulator.signed_distance, self.config.collision_weight
        )
        costs[rollout.diverged | ~_finite(rollout)] = np.inf
        return costs


def _finite(rollout: Rollout) -> BoolArray:
    """(K,) whether all places of a sample are numbers; spaces may take NaN for any place."""
    points, gripper = np.isfinite(rollout.points), np.isfinite(rollout.gripper)
    return np.asarray(points.all(axis=(1, 2, 3)) & gripper.all(axis=(1, 2)))


def _missing(name: str) -> str:
    return (
        f"episode.{name}=None, but this agent has needs_{name}=True: "
        f"build the episode with the environment's {name}"
    )
