from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from icd_agent.chain import (
    CostSpace,
    GoalSource,
    Placed,
    PointSpace,
    Spacing,
    SubgoalChain,
    WithPlaces,
)
from icd_agent.mppi.costs import squared_distance
from icd_envs.api import Float64Array, Observation
from icd_envs.errors import InvalidOptionError
from tests.agent.toy_world import ToyWorld


def clouds(*xs: float) -> Float64Array:
    """Clouds (L, 2, 3) whose points all have the given x."""
    out = np.zeros((len(xs), 2, 3))
    out[..., 0] = np.array(xs)[:, None]
    return out


def test_reached_subgoal_is_removed_with_all_before_it() -> None:
    chain = SubgoalChain(clouds(0, 1, 2, 3, 4))
    chain.advance(clouds(2.1)[0])
    assert chain.index == 3
    np.testing.assert_array_equal(chain.ahead(), clouds(3, 4))


@pytest.mark.parametrize(("offset", "index"), [(0.34, 1), (0.36, 0)])
def test_threshold_is_a_fraction_of_the_median_spacing(offset: float, index: int) -> None:
    chain = SubgoalChain(10 * clouds(1, 2, 3, 13))  # spacings 10, 10, 100
    chain.advance(10 * clouds(1 - offset)[0])
    assert chain.index == index


def test_distance_is_a_root_mean_square_whatever_the_number_of_points() -> None:
    for count in (1, 7, 200):
        subgoals = np.zeros((3, count, 3))
        subgoals[:, :, 0] = np.arange(1, 4)[:, None]
        chain = SubgoalChain(subgoals)
        chain.advance(np.full((count, 3), (0.66, 0.0, 0.0)))
        assert chain.index == 1


def test_last_subgoal_is_never_removed() -> None:
    chain = SubgoalChain(clouds(0, 1), patience=1)
    for _ in range(10):
        chain.advance(clouds(1)[0])
    assert chain.index == 1
    assert len(chain) == 2
    np.testing.assert_array_equal(chain.ahead(), clouds(1))


def test_arrived_is_to_be_at_the_last_subgoal_now() -> None:
    chain = SubgoalChain(clouds(0, 1, 2))
    seen = []
    for x in (0, 1, 2, 2.1, 3, 2):
        chain.advance(clouds(x)[0])
        seen.append(chain.arrived)
    assert seen == [False, False, True, True, False, True]


def test_single_subgoal_chain_keeps_its_goal() -> None:
    chain = SubgoalChain(clouds(1), patience=1)
    for x in (0.0, 1.0, 1.0):
        chain.advance(clouds(x)[0])
    np.testing.assert_array_equal(chain.ahead(), clouds(1))


def test_window_hides_later_subgoals_from_cost_and_removal() -> None:
    chain = SubgoalChain(clouds(0, 1, 2, 3, 4), window=2)
    np.testing.assert_array_equal(chain.ahead(), clouds(0, 1))
    chain.advance(clouds(4)[0])
    assert chain.index == 0
    chain.advance(clouds(1)[0])
    np.testing.assert_array_equal(chain.ahead(), clouds(2, 3))


def test_what_is_off_the_way_does_not_keep_a_subgoal_from_being_passed() -> None:
    def indices(passed: float | None, off: float) -> list[int]:
        chain = SubgoalChain(clouds(1, 2, 3), passed=passed, begin=clouds(0)[0])
        found = []
        for x in (0.0, 0.6, 0.8, 1.6, 1.8):
            state = clouds(x)[0]
            state[..., 1] = off
            chain.advance(state)
            found.append(chain.index)
        return found

    for off in (0.0, 0.5, 50.0):
        assert indices(0.7, off) == [0, 0, 1, 1, 2]
    assert indices(None, 50.0) == [0, 0, 0, 0, 0]


def test_two_equal_subgoals_do_not_hold_the_chain_up() -> None:
    chain = SubgoalChain(clouds(1, 1, 2), threshold=0.0, passed=0.7)
    for x in (0.0, 0.9, 0.9):
        chain.advance(clouds(x)[0])
    assert chain.index == 2


def test_patience_skips_one_subgoal_after_so_many_steps() -> None:
    chain = SubgoalChain(clouds(0, 1, 2, 3), patience=3)
    indices = []
    for _ in range(12):
        chain.advance(clouds(-9)[0])
        indices.append(chain.index)
    assert indices == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]


def test_progress_restores_patience() -> None:
    chain = SubgoalChain(clouds(0, 1, 2, 3), patience=3)
    indices = []
    for x in (-9, -9, 0, -9, -9, -9, -9):
        chain.advance(clouds(x)[0])
        indices.append(chain.index)
    assert indices == [0, 0, 1, 1, 1, 2, 2]


@pytest.mark.parametrize(("spacing", "index"), [("median", 3), ("own", 4)])
def test_subgoals_that_lie_apart_may_be_reached_from_farther_away(
    spacing: Spacing, index: int
) -> None:
    subgoals = clouds(0, 1, 2, 3, 13, 14)
    chain = SubgoalChain(subgoals, threshold=0.5, window=1, spacing=spacing)
    for x in (0, 1, 2, 3):
        chain.advance(clouds(x)[0])
    assert chain.index == 4
    chain.advance(clouds(9)[0])
    assert chain.index == index + 1


def test_subgoals_that_lie_close_need_not_be_reached_more_closely_than_others() -> None:
    for spacing in get_args(Spacing):
        chain = SubgoalChain(clouds(0, 10, 20, 21, 31), 0.5, window=1, spacing=spacing)
        for x in (0, 10, 20):
            chain.advance(clouds(x)[0])
        assert chain.index == 3
        chain.advance(clouds(17)[0])
        assert chain.index == 4


def test_chain_keeps_its_own_copy() -> None:
    subgoals = clouds(0, 1).astype(np.float32)
    chain = SubgoalChain(subgoals)
    subgoals[:] = 7
    np.testing.assert_array_equal(chain.ahead(), clouds(0, 1))


@pytest.mark.parametrize("bad", [np.zeros((0, 5, 3)), np.zeros((5, 3)), np.full((2, 5, 3), np.nan)])
def test_unusable_chain_is_refused(bad: Float64Array) -> None:
    with pytest.raises(InvalidOptionError, match="subgoals"):
        SubgoalChain(bad)


class Norms:
    """A space that is not made of points, in which the goal's scene differs."""

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        return Placed(
            lambda points: np.linalg.norm(points, axis=-1, keepdims=True),
            lambda points: 2.0 * np.linalg.norm(points, axis=-1, keepdims=True),
        )


@pytest.mark.parametrize("space", [PointSpace(), Norms()])
def test_goal_is_a_chain_of_one_that_can_be_drawn_whatever_the_space(space: CostSpace) -> None:
    world = ToyWorld()
    observation = world.observation()
    placed = space.place(observation)
    chain = GoalSource().chain(world.episode(), observation, placed, np.random.default_rng(0))
    goal = observation["desired_goal"]
    np.testing.assert_array_equal(chain.features, placed.goal(goal)[None])
    np.testing.assert_array_equal(chain.clouds, goal[None])


def test_places_beside_features_add_their_squared_distance() -> None:
    world, rng = ToyWorld(), np.random.default_rng(0)
    observation = world.observation()
    points, subgoals = rng.normal(size=(2, 3, 5, 3)), rng.normal(size=(4, 5, 3))
    alone = Norms().place(observation)
    beside = WithPlaces(Norms(), 0.5).place(observation)
    for features, joined in ((alone.here, beside.here), (alone.goal, beside.goal)):
        found = squared_distance(joined(points), joined(subgoals))
        contacts = squared_distance(features(points), features(subgoals))
        np.testing.assert_allclose(
            found, contacts + 0.25 * squared_distance(points, subgoals), rtol=1e-5
        )
