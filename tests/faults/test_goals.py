"""Goals that are met already, cannot be reached, or lie outside the world."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from baselines.pc_mppi import make_pc_mppi
from icd_agent.tracking import SubgoalTracker
from icd_envs.api import Float32Array, Observation, SimState
from icd_envs.errors import InvalidObservationError
from icd_envs.tasks.base import HOLD_STEPS
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import plant_of, random_actions, remake

GOALS: dict[str, Callable[[ContactEnv[Any], Float32Array], Float32Array]] = {
    "met": lambda env, goal: plant_of(env).points(),
    "far away": lambda env, goal: goal + np.float32([3.9, 0.0, 0.0]),
    "under the floor": lambda env, goal: goal - np.float32([0.0, 0.0, 1.0]),
    "inside out": lambda env, goal: goal[::-1].copy(),
    "one point": lambda env, goal: np.repeat(goal[:1], len(goal), axis=0),
    "outside the world": lambda env, goal: goal + np.float32([1e6, -1e6, 0.0]),
}
Aim = Callable[[str], Observation]
"""Starts the episode anew with another goal, by name."""


@pytest.fixture
def aim(env: ContactEnv[Any], start: SimState) -> Iterator[Aim]:
    """The scene as it is, with a goal that no expert would have shown."""
    problem = env._problem
    assert problem is not None

    def aim_at(kind: str) -> Observation:
        env.restore(start)
        goal = GOALS[kind](env, problem.goal)
        oracle = dataclasses.replace(problem.goal_oracle, points=goal[None])
        env._problem = dataclasses.replace(problem, goal_oracle=oracle)
        return env.restore(start)

    yield aim_at
    env._problem = problem
    env.restore(start)


def test_goal_that_is_already_met_is_held_and_where_that_suffices_ends_the_episode(
    env: ContactEnv[Any], aim: Aim
) -> None:
    observation = aim("met")
    for step in range(1, HOLD_STEPS + 1):
        observation, reward, terminated, truncated, info = env.step(np.zeros(3))
        assert (reward, info["is_success"], info["complete_rate"]) == (0.0, True, 1.0)
        ends = env.episode().ends_on_success and step == HOLD_STEPS
        assert (terminated, truncated) == (ends, False)
    desired = observation["desired_goal"]
    assert env.compute_reward(plant_of(env).points(), desired, info) == 0.0


@pytest.mark.parametrize("kind", GOALS)
def test_any_goal_has_a_defined_reward(env: ContactEnv[Any], aim: Aim, kind: str) -> None:
    aim(kind)
    dense: Any = remake(env, reward_type="dense").unwrapped
    for action in random_actions(4, 3):
        observation, reward, terminated, truncated, info = env.step(action)
        assert reward in (-1.0, 0.0)
        assert (reward == 0.0) == info["is_success"] == (info["complete_rate"] == 1.0)
        assert 0.0 <= info["complete_rate"] <= 1.0
        assert (terminated, truncated) == (False, False)
        achieved, desired = plant_of(env).points(), observation["desired_goal"]
        assert env.compute_reward(achieved, desired, info) == reward
        shaped = dense.compute_reward(achieved, desired, info)
        assert np.isfinite(shaped)
        assert shaped <= reward


def planner() -> SubgoalTracker:
    """PC-MPPI, with few samples."""
    agent = make_pc_mppi()
    agent.mppi_config = dataclasses.replace(agent.mppi_config, samples=6, horizon=3)
    return agent


@pytest.mark.parametrize("kind", GOALS)
def test_planner_returns_with_an_action_and_a_status(
    env: ContactEnv[Any], aim: Aim, kind: str
) -> None:
    observation, agent = aim(kind), planner()
    agent.reset(env.episode(simulator=True), seed=0)
    for _ in range(2):
        action = agent.act(observation)
        assert env.action_space.contains(action)
        assert agent.plan_info is not None
        assert (agent.plan_info.status, agent.plan_info.invalid_samples) == ("ok", 0)
        assert np.isfinite(agent.plan_info.best_cost)
        observation, *_, info = env.step(action)
        assert not info["diverged"]


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_planner_names_a_goal_that_is_not_finite(
    env: ContactEnv[Any], start: SimState, value: float
) -> None:
    observation, agent = env.restore(start), planner()
    agent.reset(env.episode(simulator=True), seed=0)
    goal = np.full_like(observation["desired_goal"], value)
    with pytest.raises(InvalidObservationError, match="desired_goal has NaN"):
        agent.act({**observation, "desired_goal": goal})
    assert env.action_space.contains(agent.act(observation))
