from __future__ import annotations

import copy

import numpy as np
import pytest

from icd_agent.chain import GoalSource, Placed, PointSpace, Subgoals
from icd_agent.mppi.presets import PAPER
from icd_agent.tracking import SubgoalTracker, TrackerConfig
from icd_envs.api import Agent, Episode, Float64Array, FloatArray, Observation
from icd_envs.errors import EpisodeStateError, InvalidOptionError
from tests.agent.toy_world import ToyWorld, cloud_at


class Waypoints:
    """Subgoals at given gripper positions."""

    needs_oracle = False

    def __init__(self, *positions: tuple[float, float, float]) -> None:
        self.positions = np.array(positions)

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        clouds = cloud_at(self.positions)
        return Subgoals(clouds, clouds)


def goal_tracker(config: TrackerConfig | None = None) -> SubgoalTracker:
    return SubgoalTracker(GoalSource(), PointSpace(), PAPER, config)


def drive(tracker: SubgoalTracker, world: ToyWorld, steps: int, seed: int = 0) -> Float64Array:
    """Gripper positions (steps + 1, 3) of one episode."""
    tracker.reset(world.episode(), seed)
    path = [world.position]
    for _ in range(steps):
        world.step(tracker.act(world.observation()))
        path.append(world.position)
    return np.array(path)


def closest(path: Float64Array, place: tuple[float, float, float]) -> float:
    return float(np.linalg.norm(path - np.array(place), axis=1).min())


def test_goal_tracker_reaches_the_goal_and_is_an_agent() -> None:
    tracker = goal_tracker()
    assert isinstance(tracker, Agent)
    assert tracker.needs_simulator
    assert not tracker.needs_oracle
    path = drive(tracker, ToyWorld(), 30)
    assert np.linalg.norm(path[-1] - (0.3, 0.0, 0.0)) < 0.02


def test_chain_makes_the_detour_that_the_goal_alone_would_not() -> None:
    detour = [(0.0, 0.1, 0.0), (0.0, 0.2, 0.0), (0.15, 0.2, 0.0), (0.3, 0.2, 0.0), (0.3, 0.1, 0.0)]
    goal = (0.3, 0.0, 0.0)
    source = Waypoints(*detour, goal)
    tracker = SubgoalTracker(source, PointSpace(), PAPER, TrackerConfig(window=1, patience=None))
    path = drive(tracker, ToyWorld(goal=goal), 60)
    reached = [int(np.linalg.norm(path - np.array(p), axis=1).argmin()) for p in (*detour, goal)]
    assert reached == sorted(reached)
    assert all(closest(path, place) < 0.04 for place in (*detour, goal))
    straight = drive(goal_tracker(), ToyWorld(goal=goal), 60)
    assert closest(straight, (0.15, 0.2, 0.0)) > 0.15


def test_minimum_over_all_takes_the_short_cut_that_a_window_does_not() -> None:
    # A loop: out along +y and back, ending next to where it began.
    loop = [(0.0, 0.1, 0.0), (0.0, 0.2, 0.0), (0.1, 0.2, 0.0), (0.1, 0.1, 0.0), (0.05, 0.0, 0.0)]
    furthest = {}
    for window in (1, None):
        tracker = SubgoalTracker(
            Waypoints(*loop), PointSpace(), PAPER, TrackerConfig(window=window)
        )
        furthest[window] = drive(tracker, ToyWorld(goal=loop[-1]), 40)[:, 1].max()
    assert furthest[1] > 0.15
    assert furthest[None] < 0.1


def test_patience_gives_up_on_a_subgoal_that_cannot_be_reached() -> None:
    class Fenced(ToyWorld):
        """The gripper cannot get above y = 0.05."""

        def step(self, action: FloatArray) -> None:
            super().step(action)
            self.position[1] = min(self.position[1], 0.05)

    source = Waypoints((0.0, 0.3, 0.0), (0.2, 0.0, 0.0))
    for patience, arrives in ((5, True), (None, False)):
        tracker = SubgoalTracker(
            source, PointSpace(), PAPER, TrackerConfig(window=1, patience=patience)
        )
        path = drive(tracker, Fenced(), 30)
        assert (closest(path, (0.2, 0.0, 0.0)) < 0.03) == arrives


def test_collision_cost_keeps_the_gripper_out_of_a_ball() -> None:
    ball, radius, gripper_radius = (0.15, 0.01, 0.0), 0.05, 0.02
    kept = drive(goal_tracker(TrackerConfig(collision_weight=10.0)), ToyWorld(ball=ball), 50)
    free = drive(goal_tracker(TrackerConfig(collision_weight=0.0)), ToyWorld(ball=ball), 50)
    assert closest(kept, ball) > radius + gripper_radius - 0.01
    assert closest(free, ball) < radius
    assert np.linalg.norm(kept[-1] - (0.3, 0.0, 0.0)) < 0.03


def test_actions_follow_from_the_seed_and_not_from_the_global_state() -> None:
    first = drive(goal_tracker(), ToyWorld(), 5, seed=3)
    np.random.seed(99)  # noqa: NPY002 - the global state is what must not matter
    before = np.random.get_state(legacy=False)  # noqa: NPY002
    tracker = goal_tracker()
    other = drive(tracker, ToyWorld(), 5, seed=4)
    again = drive(tracker, ToyWorld(), 5, seed=3)
    after = np.random.get_state(legacy=False)  # noqa: NPY002
    np.testing.assert_array_equal(first, again)
    assert (first[1] != other[1]).any()
    np.testing.assert_equal(after, before)


def test_observation_is_not_changed() -> None:
    world, tracker = ToyWorld(), goal_tracker()
    tracker.reset(world.episode(), 0)
    observation = world.observation()
    for value in observation.values():
        value.setflags(write=False)  # type: ignore[attr-defined]
    before = copy.deepcopy(observation)
    tracker.act(observation)
    for key, value in before.items():
        np.testing.assert_array_equal(observation[key], value)  # type: ignore[literal-required]


def test_action_is_float32_in_the_box_and_plan_info_reports_it() -> None:
    world, tracker = ToyWorld(), goal_tracker()
    tracker.reset(world.episode(), 0)
    assert tracker.plan_info is None
    action = tracker.act(world.observation())
    assert action.dtype == np.float32
    assert action.shape == (3,)
    assert np.abs(action).max() <= 1
    info = tracker.plan_info
    assert info is not None
    assert (info.status, info.subgoal, info.chain_length, info.invalid_samples) == ("ok", 0, 1, 0)
    assert 0 < info.best_cost <= info.mean_cost
    assert 1 <= info.effective_samples <= 80
    assert min(info.rollout_seconds, info.cost_seconds, info.update_seconds) > 0
    assert world.last_actions is not None
    assert world.last_actions.shape == (80, 10, 3)


@pytest.mark.parametrize("void", [0.0, 1e30, np.nan])
def test_diverged_samples_are_ignored(void: float) -> None:
    world = ToyWorld(goal=(0.3, 0.0, 0.0))
    world.diverged, world.void = np.arange(80) % 2 == 1, void
    tracker = goal_tracker()
    path = drive(tracker, world, 30)
    assert np.linalg.norm(path[-1] - (0.3, 0.0, 0.0)) < 0.03
    assert tracker.plan_info is not None
    assert tracker.plan_info.invalid_samples == 40


def test_all_diverged_holds_still_and_says_so() -> None:
    world, tracker = ToyWorld(), goal_tracker()
    world.diverged = np.ones(80, bool)
    tracker.reset(world.episode(), 0)
    np.testing.assert_array_equal(tracker.act(world.observation()), np.zeros(3))
    first = tracker.plan_info
    assert first is not None
    assert first.status == "all rollouts diverged"
    world.diverged = None
    tracker.act(world.observation())
    second = tracker.plan_info
    assert second is not None
    assert second.status == "ok"


def test_calls_out_of_order_and_missing_simulator_are_refused() -> None:
    world = ToyWorld()
    with pytest.raises(EpisodeStateError, match="reset"):
        goal_tracker().act(world.observation())
    bare = Episode("toy", 0.03, 0.05, 10, cloud_at(np.zeros(3)), np.zeros((0, 4), np.float32))
    with pytest.raises(InvalidOptionError, match=r"episode\.simulator=None"):
        goal_tracker().reset(bare, 0)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("threshold", -1.0),
        ("window", 0),
        ("patience", 0),
        ("passed", 1.5),
        ("collision_weight", np.nan),
    ],
)
def test_bad_tracker_option_is_named(field: str, value: float) -> None:
    with pytest.raises(InvalidOptionError, match=f"{field}="):
        TrackerConfig(**{field: value})  # type: ignore[arg-type]


class Again(Waypoints):
    """Answers every later question with another chain, or keeps the last one."""

    def __init__(self, first: tuple[float, float, float], then: Subgoals | None) -> None:
        super().__init__(first)
        self._then = then
        self.asked: list[int | None] = []

    def again(
        self,
        episode: Episode,
        observation: Observation,
        space: Placed,
        rng: np.random.Generator,
        index: int | None,
    ) -> Subgoals | None:
        self.asked.append(index)
        return self._then


def test_a_source_is_asked_again_and_its_answer_followed() -> None:
    there = cloud_at(np.array([(0.0, 0.3, 0.0)]))
    source = Again((0.3, 0.0, 0.0), Subgoals(there, there))
    config = TrackerConfig(patience=None, replan_every=10)
    tracker = SubgoalTracker(source, PointSpace(), PAPER, config)
    path = drive(tracker, ToyWorld(), 45)
    assert len(source.asked) == 4
    assert np.linalg.norm(path[-1] - (0.0, 0.3, 0.0)) < 0.02
    assert closest(path, (0.2, 0.0, 0.0)) < 0.05  # the first chain was followed until then


def test_a_source_that_keeps_its_chain_changes_nothing() -> None:
    config = TrackerConfig(patience=None, replan_every=3)
    tracker = SubgoalTracker(Again((0.3, 0.0, 0.0), None), PointSpace(), PAPER, config)
    kept = drive(tracker, ToyWorld(), 20)
    tracker = SubgoalTracker(
        Waypoints((0.3, 0.0, 0.0)), PointSpace(), PAPER, TrackerConfig(patience=None)
    )
    np.testing.assert_array_equal(kept, drive(tracker, ToyWorld(), 20))


def test_a_source_is_asked_when_patience_runs_out() -> None:
    source = Again((9.0, 0.0, 0.0), None)
    config = TrackerConfig(patience=5, replan_every=1000)
    drive(SubgoalTracker(source, PointSpace(), PAPER, config), ToyWorld(), 20)
    assert source.asked == [None] * 3  # the only subgoal was followed in vain


def test_a_source_hears_which_subgoal_is_next_or_that_none_is_left() -> None:
    source = Again((9.0, 0.0, 0.0), None)
    source.positions = np.array([(8.0, 0.0, 0.0), (9.0, 0.0, 0.0)])
    config = TrackerConfig(patience=5, replan_every=4)
    drive(SubgoalTracker(source, PointSpace(), PAPER, config), ToyWorld(), 16)
    assert source.asked == [0, 1, None, None]


def test_a_reached_end_is_waited_at_no_longer_than_any_other_subgoal() -> None:
    source = Again((0.0, 0.0, 0.0), None)
    config = TrackerConfig(patience=5, replan_every=1000, threshold=1e3)
    drive(SubgoalTracker(source, PointSpace(), PAPER, config), ToyWorld(), 20)
    assert source.asked == [None] * 3


def asked_beside_the_end(threshold: float, *, ends_on_success: bool) -> list[int | None]:
    """What a source hears while the gripper waits 2 mm from the last of two subgoals."""
    source = Again((0.0, 0.0, 0.0), None)
    source.positions = np.array([(0.0, 0.0, 0.0), (0.002, 0.0, 0.0)])
    config = TrackerConfig(patience=5, replan_every=1000, threshold=threshold)
    world = ToyWorld(ends_on_success=ends_on_success)
    drive(SubgoalTracker(source, PointSpace(), PAPER, config), world, 20)
    return source.asked


def test_an_end_that_must_be_kept_is_stayed_at_and_else_left_for_a_shorter_chain_only() -> None:
    assert asked_beside_the_end(1e3, ends_on_success=False) == []
    assert asked_beside_the_end(0.0, ends_on_success=False) == [1] * 3
    assert asked_beside_the_end(1e3, ends_on_success=True) == [None] * 3


def test_only_a_source_that_can_be_asked_again_may_be_asked() -> None:
    with pytest.raises(InvalidOptionError, match="replan_every=5 cannot be used with GoalSource"):
        goal_tracker(TrackerConfig(replan_every=5))
