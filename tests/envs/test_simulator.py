from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.api import Rollout, SimState, Simulator
from icd_envs.errors import EpisodeStateError, IncompatibleStateError, InvalidActionError
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.physics.guard import BOUND
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import make, plant_of, random_actions


@pytest.fixture(scope="module", params=ENV_IDS)
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    env = make(request.param)
    env.reset(seed=0)
    yield env
    env.close()


@pytest.fixture(scope="module")
def simulator(env: ContactEnv[Any]) -> Simulator:
    found = env.episode(simulator=True).simulator
    assert isinstance(found, Simulator)
    return found


@pytest.fixture(scope="module")
def state(env: ContactEnv[Any]) -> SimState:
    for action in random_actions(9, 10):
        env.step(action)
    return env.snapshot()


def bits(rollout: Rollout, samples: list[int] | slice = slice(None)) -> tuple[bytes, ...]:
    return tuple(np.ascontiguousarray(value[samples]).tobytes() for value in vars(rollout).values())


def test_shapes_and_types_are_those_of_the_protocol(simulator: Simulator, state: SimState) -> None:
    rollout = simulator.rollout(state, random_actions(0, 3, 4))
    assert rollout.points.shape == (3, 4, 200, 3)
    assert rollout.gripper.shape == (3, 4, 3)
    assert rollout.diverged.shape == (3,)
    assert (rollout.points.dtype, rollout.gripper.dtype) == (np.float32, np.float32)
    assert rollout.diverged.dtype == bool
    assert not rollout.diverged.any()


def test_sample_does_not_depend_on_its_neighbours(simulator: Simulator, state: SimState) -> None:
    actions = random_actions(1, 6, 5)
    together = simulator.rollout(state, actions)
    order = np.random.default_rng(0).permutation(6)
    assert bits(simulator.rollout(state, actions[order])) == bits(together, order.tolist())
    for k in range(6):
        assert bits(simulator.rollout(state, actions[k : k + 1])) == bits(together, [k])


def test_longer_horizon_begins_with_the_shorter(simulator: Simulator, state: SimState) -> None:
    actions = random_actions(2, 3, 8)
    long, short = simulator.rollout(state, actions), simulator.rollout(state, actions[:, :3])
    assert long.points[:, :3].tobytes() == short.points.tobytes()
    assert long.gripper[:, :3].tobytes() == short.gripper.tobytes()


def test_two_rollouts_in_a_row_equal_one(env: ContactEnv[Any], simulator: Simulator) -> None:
    actions = random_actions(3, 1, 12)
    start = env.snapshot()
    whole = simulator.rollout(start, actions)
    for action in actions[0, :6]:
        env.step(action)
    rest = simulator.rollout(env.snapshot(), actions[:, 6:])
    assert rest.points.tobytes() == whole.points[:, 6:].tobytes()
    env.restore(start)


def test_actions_beyond_the_box_are_clipped(simulator: Simulator, state: SimState) -> None:
    actions = 3 * random_actions(4, 2, 5)
    assert bits(simulator.rollout(state, actions)) == bits(
        simulator.rollout(state, np.clip(actions, -1, 1))
    )


def test_list_of_actions_is_accepted_and_the_argument_kept(
    simulator: Simulator, state: SimState
) -> None:
    actions = 2 * random_actions(5, 2, 3)
    before = actions.copy()
    assert bits(simulator.rollout(state, actions)) == bits(
        simulator.rollout(state, actions.tolist())
    )
    np.testing.assert_array_equal(actions, before)


@pytest.mark.parametrize("velocity", [1e6, 1e9, 1e200])
def test_diverged_samples_are_flagged_and_finite_and_leave_no_trace(
    env: ContactEnv[Any], simulator: Simulator, state: SimState, velocity: float
) -> None:
    actions = random_actions(6, 3, 5)
    before = bits(simulator.rollout(state, actions))
    env.restore(state)
    plant_of(env).data.qvel[7] = velocity
    rollout = simulator.rollout(env.snapshot(), actions)
    assert rollout.diverged.all()
    assert np.all(np.abs(rollout.points) < BOUND)
    assert np.all(np.abs(rollout.gripper) < BOUND)
    assert bits(simulator.rollout(state, actions)) == before
    env.restore(state)


@pytest.mark.parametrize(
    "actions",
    [
        np.zeros((2, 3)),
        np.zeros((1, 2, 4)),
        np.zeros((0, 2, 3)),
        np.zeros((2, 0, 3)),
        np.full((1, 1, 3), np.nan),
        np.full((1, 1, 3), np.inf),
        "left",
        [[[0.0, 0.0, 0.0], [0.0]]],
        None,
    ],
)
def test_unusable_actions_are_refused(
    simulator: Simulator, state: SimState, actions: object
) -> None:
    with pytest.raises(InvalidActionError, match="actions"):
        simulator.rollout(state, actions)


def test_unusable_state_is_refused(simulator: Simulator, state: SimState) -> None:
    nan = np.full_like(state.physics, np.nan)
    for change in ({"scene_id": "another"}, {"physics": state.physics[:-1]}, {"physics": nan}):
        with pytest.raises(IncompatibleStateError):
            simulator.rollout(dataclasses.replace(state, **change), np.zeros((1, 1, 3)))


def test_signed_distance_is_that_of_the_fixtures(
    env: ContactEnv[Any], simulator: Simulator
) -> None:
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    points = np.random.default_rng(7).uniform(-0.5, 0.8, (500, 3))
    expected = BoxUnion(env.task.boxes(oracle.scene))(points)
    np.testing.assert_array_equal(simulator.signed_distance(points), expected)
    cloud = env.restore(env.snapshot())["scene"]
    assert np.abs(simulator.signed_distance(cloud[:800])).max() < 1e-5


def test_simulator_of_a_past_episode_says_so(env: ContactEnv[Any]) -> None:
    other = make(env.task.env_id)
    other.reset(seed=0)
    old = other.episode(simulator=True, threads=2).simulator
    assert old is not None
    other.reset(seed=0)
    state = old.snapshot()
    with pytest.raises(EpisodeStateError, match="episode"):
        old.rollout(state, np.zeros((1, 1, 3)))
    new = other.episode(simulator=True).simulator
    assert new is not None
    assert not new.rollout(state, np.zeros((1, 1, 3))).diverged.any()
    other.close()
    with pytest.raises(EpisodeStateError):
        new.rollout(state, np.zeros((1, 1, 3)))
