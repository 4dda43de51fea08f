"""A chain of subgoals and which of them are still ahead."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np

from icd_agent.mppi.costs import squared_distance
from icd_agent.options import require
from icd_envs.api import Episode, FloatArray, Observation

Features = Callable[[FloatArray], FloatArray]
"""Maps clouds (..., N, 3) [m] in the world frame to features (..., N, D)."""


Spacing = Literal["median", "own"]


class Placed(NamedTuple):
    """A cost space in the scenes of one episode.

    Attributes:
        here: features in the present scene; quick, for many clouds at once.
        goal: features in the scene that the goal was specified in; the same except in the
            adaptation tasks, and may be slow.
        back: clouds (..., N, 3) [m] of features (..., N, D), where features are places; else None.
        beside: how many of the D features are not the space's own: the last ones, see
            ``WithPlaces``.
    """

    here: Features
    goal: Features
    back: Features | None = None
    beside: int = 0


class CostSpace(Protocol):
    """Where distances between object states are measured."""

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        """Get ready for an episode.

        Args:
            observation: the first one.
            foreign: the goal was specified in another scene, ``Episode.foreign_goal``; what is
                observed of the present one is partial or noisy, so that clouds do not tell.
        """
        ...


class Subgoals(NamedTuple):
    """A chain from now to the goal.

    Attributes:
        features: (L, N, D) in the cost space, L >= 1.
        clouds: (L, N, 3) [m] the same as object clouds, for viewers; None if the source has none.
        begin: (N, D) where the chain begins, as the source sees it; None is the present state.
        steps: (L,) predicted control steps to each from the one before, to the first from now; None
            if the source predicts none.
    """

    features: FloatArray
    clouds: FloatArray | None = None
    begin: FloatArray | None = None
    steps: FloatArray | None = None


class SubgoalSource(Protocol):
    """Where subgoals come from.

    Attributes:
        needs_oracle: whether ``episode.oracle`` must be there.
    """

    needs_oracle: bool

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Subgoals from now to the goal, in ``space``.

        Args:
            episode: what is known of it.
            observation: the present one.
            space: in which distances are measured.
            rng: source of every draw.
        """
        ...


@runtime_checkable
class ReplanningSource(SubgoalSource, Protocol):
    """A source that can be asked again on the way."""

    def again(
        self,
        episode: Episode,
        observation: Observation,
        space: Placed,
        rng: np.random.Generator,
        index: int | None,
    ) -> Subgoals | None:
        """Return another chain from now to the goal, or None to keep what is left of the last.

        Args:
            episode: what is known of it.
            observation: the present one.
            space: in which distances are measured.
            rng: source of every draw.
            index: of the next subgoal of the last chain; None if that chain has been followed to
                its end in vain.
        """
        ...


class PointSpace:
    """World coordinates as they are; distances are metres."""

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        """Clouds are their own features, wherever they are."""
        return Placed(_unchanged, _unchanged, _unchanged)


def _unchanged(points: FloatArray) -> FloatArray:
    return points


class WithPlaces:
    """Another space's features, and beside them the world coordinates.

    Descriptors tell contacts apart, but far from fixtures they hardly change; places do.
    """

    def __init__(self, space: CostSpace, weight: float) -> None:
        """Choose.

        Args:
            space: whose features come first.
            weight: of a metre.
        """
        self._space = space
        self._weight = np.float32(weight)

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        """Place the other space; (..., N, D) become (..., N, D + 3)."""
        placed = self._space.place(observation, foreign=foreign)
        here, goal = self._beside(placed.here), self._beside(placed.goal)
        return Placed(here, goal, beside=placed.beside + 3)

    def _beside(self, features: Features) -> Features:
        def joined(points: FloatArray) -> FloatArray:
            places = self._weight * np.asarray(points, np.float32)
            return np.concatenate([features(points), places], axis=-1)

        return joined


class GoalSource:
    """The goal itself as the only subgoal."""

    needs_oracle = False

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Return the desired object cloud, as it lies in the goal's scene, as a chain of one."""
        cloud = observation["desired_goal"][None]
        return Subgoals(space.goal(cloud), cloud)


class SubgoalChain:
    """Subgoals in order; those reached are removed together with all before them.

    The last subgoal is never removed. Distances are root mean squares over the points; the
    threshold scales with the chain, because its spacing differs between spaces and sources.
    """

    def __init__(
        self,
        subgoals: FloatArray,
        threshold: float = 0.35,
        window: int | None = None,
        patience: int | None = None,
        spacing: Spacing = "median",
        passed: float | None = None,
        begin: FloatArray | None = None,
    ) -> None:
        """Begin with every subgoal ahead; ``TrackerConfig`` checks the options.

        Args:
            subgoals: (L, N, D) in the cost space.
            threshold: a subgoal is reached within this fraction of the median distance between
                consecutive subgoals.
            window: only the next so many subgoals may be aimed at or reached; None is all.
            patience: after so many steps without a subgoal removed, one is skipped; None is never.
            spacing: "own" replaces that median by the distance to the subgoal before, if it is
                larger.
            passed: the next subgoal is also reached once this fraction of the way to it from the
                one before is done; None is never.
            begin: (N, D) where the way to the first subgoal begins; None is the first state.

        Raises:
            InvalidOptionError: for an empty or non-finite chain.
        """
        shape = np.shape(subgoals)
        require(len(shape) == 3 and min(shape) >= 1, "subgoals.shape", shape, "(L, N, D), L >= 1")
        require(bool(np.isfinite(subgoals).all()), "subgoals", "NaN or inf", "finite subgoals")
        self._subgoals = np.array(subgoals, dtype=np.float32)
        self._window = len(self._subgoals) if window is None else window
        self._patience = patience
        self._passed = passed
        self._begin = begin
        apart = np.sqrt(np.mean(np.sum(np.diff(self._subgoals, axis=0) ** 2, axis=-1), axis=-1))
        reach = np.full(len(self._subgoals), np.median(apart) if len(apart) else 0.0)
        if spacing == "own":
            reach[1:] = np.maximum(reach[1:], apart)
        self._reach_squared = (threshold * reach) ** 2
        self._index = 0
        self._steps_since_progress = 0
        self._arrived = False

    def __len__(self) -> int:
        """L, removed subgoals included."""
        return len(self._subgoals)

    @property
    def index(self) -> int:
        """Index of the next subgoal; L - 1 from the time only the last is left."""
        return self._index

    @property
    def at_end(self) -> bool:
        """Whether only the last subgoal is left."""
        return self._index == len(self._subgoals) - 1

    @property
    def arrived(self) -> bool:
        """Whether the last subgoal's threshold held when ``advance`` last looked."""
        return self._arrived

    def ahead(self) -> FloatArray:
        """Return the subgoals to aim at now, (W, N, D) with 1 <= W <= window."""
        return self._subgoals[self._index : self._index + self._window]

    def advance(self, current: FloatArray) -> bool:
        """Remove what has been reached, or skip one subgoal if patience has run out.

        Args:
            current: (N, D) present state in the cost space; call once per control step.

        Returns:
            Whether patience has run out. At the last subgoal it does even if that is reached: most
            episodes that have solved their task are over; in others, ask ``arrived``.
        """
        if self._begin is None:
            self._begin = np.array(current)
        reached = self._last_reached(current)
        self._arrived = reached == len(self._subgoals) - 1
        index = self._index + self._is_passed(current) if reached is None else reached + 1
        patience, waited = self._patience, self._steps_since_progress
        progress = index > self._index and not self.at_end
        stalled = not progress and patience is not None and waited >= patience
        index = min(index + stalled, len(self._subgoals) - 1)
        if stalled or index > self._index:
            self._steps_since_progress = 0
        self._index = index
        self._steps_since_progress += 1
        return stalled

    def _last_reached(self, current: FloatArray) -> int | None:
        """Index of the last subgoal in the window whose threshold holds now, if any."""
        squares = squared_distance(current[None, None], self.ahead())[0, 0]
        reach_squared = self._reach_squared[self._index : self._index + len(squares)]
        reached = np.flatnonzero(squares <= reach_squared)
        return self._index + int(reached[-1]) if reached.size else None

    def _is_passed(self, current: FloatArray) -> bool:
        return self._passed is not None and self._done(current) >= self._passed

    def _done(self, current: FloatArray) -> float:
        """How much of the way to the next subgoal lies behind: 0 at its beginning, 1 at its end.

        What is off the way does not count, so that subgoals that are slightly wrong, as generated
        ones are, can be reached as well as right ones.
        """
        before = self._subgoals[self._index - 1] if self._index else self._begin
        assert before is not None
        way = self._subgoals[self._index] - before
        length = float(np.sum(way * way))
        return float(np.sum((current - before) * way)) / length if length else 1.0
