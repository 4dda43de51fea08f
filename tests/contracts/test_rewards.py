"""What must hold for the reward of every environment."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import make, random_actions

REWARD_TYPES = ("sparse", "dense")

Batch = tuple[np.ndarray, np.ndarray, list[dict[str, Any]]]
"""Achieved and desired clouds (B, N, 3) and the info of each."""


@pytest.fixture(scope="module", params=[(e, r) for e in ENV_IDS for r in REWARD_TYPES])
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    env = make(request.param[0], reward_type=request.param[1])
    yield env
    env.close()


@pytest.fixture(scope="module")
def batch(env: ContactEnv[Any]) -> Batch:
    """Transitions of two scenes, by the expert and at random, most of them relabelled.

    A goal is the episode's own, a later state of it, or that of an episode in a third scene.
    """
    other, other_info = env.reset(seed=2)
    elsewhere = {name: value for name, value in other_info.items() if name.startswith("goal_")}
    achieved, desired, infos = [], [], []
    for seed in (0, 1):
        env.reset(seed=seed)
        oracle = env.episode(oracle=True).oracle
        assert oracle is not None
        steps = []
        for action in [*oracle.actions, *random_actions(seed, 20)]:
            observation, reward, *_, info = env.step(action)
            steps.append((observation, info))
            goal = observation["desired_goal"]
            assert reward == env.compute_reward(observation["achieved_goal"], goal, info)
        for i in range(0, len(steps), 4):
            observation, info = steps[i]
            later = steps[min(i + 10, len(steps) - 1)][0]["achieved_goal"]
            # A state's goal is specified where the state was reached.
            here = {f"goal_{name}": info[name] for name in env.task.parameter_names}
            goal, where = [
                (observation["desired_goal"], {}),
                (later, here),
                (other["desired_goal"], elsewhere),
            ][i // 4 % 3]
            achieved.append(observation["achieved_goal"])
            desired.append(goal)
            infos.append({**info, **where})
    return np.stack(achieved), np.stack(desired), infos


def test_batch_equals_singles(env: ContactEnv[Any], batch: Batch) -> None:
    achieved, desired, infos = batch
    rewards = env.compute_reward(achieved, desired, infos)
    assert rewards.shape == (len(infos),)
    assert rewards.dtype == np.float64
    singles = [env.compute_reward(*item) for item in zip(achieved, desired, infos, strict=True)]
    assert all(type(single) is float for single in singles)
    np.testing.assert_array_equal(rewards, singles)
    np.testing.assert_array_equal(env.compute_reward(achieved, desired, np.array(infos)), rewards)


def test_order_of_the_batch_does_not_matter(env: ContactEnv[Any], batch: Batch) -> None:
    achieved, desired, infos = batch
    order = np.random.default_rng(0).permutation(len(infos))
    shuffled = env.compute_reward(achieved[order], desired[order], [infos[i] for i in order])
    np.testing.assert_array_equal(shuffled, env.compute_reward(achieved, desired, infos)[order])


def test_rewards_have_their_range_and_both_ends_occur(env: ContactEnv[Any], batch: Batch) -> None:
    rewards = env.compute_reward(*batch)
    if env.reward_type == "sparse":
        assert set(rewards) == {-1.0, 0.0}
    else:
        assert rewards.max() <= 0.0
        assert rewards.min() < -1.0


def test_what_is_achieved_is_the_best_goal(env: ContactEnv[Any], batch: Batch) -> None:
    achieved, _, infos = batch
    here = [{**i, **{f"goal_{n}": i[n] for n in env.task.parameter_names}} for i in infos]
    np.testing.assert_array_equal(env.compute_reward(achieved, achieved, here), 0.0)


def test_reward_needs_nothing_but_its_arguments(env: ContactEnv[Any], batch: Batch) -> None:
    fresh = make(env.task.env_id, reward_type=env.reward_type)
    np.testing.assert_array_equal(fresh.compute_reward(*batch), env.compute_reward(*batch))
    closed = make(env.task.env_id, reward_type=env.reward_type)
    closed.close()
    np.testing.assert_array_equal(closed.compute_reward(*batch), env.compute_reward(*batch))
