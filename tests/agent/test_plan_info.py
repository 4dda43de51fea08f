"""What can be drawn of a planner's last step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from icd_agent.chain import Placed, PointSpace, Subgoals
from icd_agent.mppi.presets import PAPER
from icd_agent.plan_info import BEST, PlanInfo
from icd_agent.tracking import SubgoalTracker
from icd_envs.api import Episode, Observation
from tests.agent.toy_world import ACTION_SCALE, POINTS, ToyWorld, cloud_at

CHAIN = cloud_at(np.array([[0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.3, 0.0, 0.0]]))


class Source:
    """A chain that can be drawn, or not."""

    needs_oracle = False

    def __init__(self, *, drawable: bool) -> None:
        self._drawable = drawable

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        return Subgoals(CHAIN, CHAIN if self._drawable else None)


def planned(world: ToyWorld, *, drawable: bool = True) -> tuple[SubgoalTracker, PlanInfo]:
    """A tracker after its first step."""
    tracker = SubgoalTracker(Source(drawable=drawable), PointSpace(), PAPER)
    tracker.reset(world.episode(), 0)
    assert tracker.plan_view() is None
    world.step(tracker.act(world.observation()))
    assert tracker.plan_info is not None
    return tracker, tracker.plan_info


def test_view_shows_subgoals_plan_and_the_best_samples() -> None:
    world = ToyWorld()
    tracker, info = planned(world)
    view = tracker.plan_view()
    assert view is not None
    assert view.status == "ok, subgoal 1 of 3"
    np.testing.assert_array_equal(view.subgoals, CHAIN)
    assert view.subgoal == 0
    assert view.paths is not None
    assert view.ends is not None
    assert view.paths.shape == (BEST, 10, 3)
    best = np.argsort(info.costs)[:BEST]
    np.testing.assert_array_equal(view.paths, info.rollout.gripper[best])
    np.testing.assert_array_equal(view.ends, info.rollout.points[best, -1])
    assert view.ends.shape == (BEST, POINTS, 3)


def test_plan_begins_with_the_action_taken() -> None:
    world = ToyWorld()
    _, info = planned(world)
    assert info.actions.shape == (10, 3)
    np.testing.assert_allclose(world.position, ACTION_SCALE * info.actions[0], atol=1e-7)


def test_nothing_is_copied_in_the_planning_step() -> None:
    world = ToyWorld()
    _, info = planned(world)
    assert info.subgoals is CHAIN
    assert world.last_rollout is info.rollout


def test_samples_that_diverged_are_not_shown() -> None:
    world = ToyWorld()
    world.diverged = np.ones(80, bool)
    world.diverged[:2] = False
    _, info = planned(world)
    view = info.view()
    assert view.paths is not None
    assert len(view.paths) == 2
    nothing = replace(info, costs=np.full(80, np.inf)).view()
    assert nothing.paths is not None
    assert nothing.paths.shape == (0, 10, 3)


def test_chain_that_is_no_cloud_is_not_shown() -> None:
    tracker, _ = planned(ToyWorld(), drawable=False)
    view = tracker.plan_view()
    assert view is not None
    assert view.subgoals is None
    assert view.paths is not None
