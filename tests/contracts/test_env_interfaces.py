"""What users and libraries may expect of every environment."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import digest, make, play, random_actions

INFO = {"is_success": bool, "complete_rate": float, "diverged": bool, "action_clipped": bool}


def test_observations_and_info_keep_their_promises(env: ContactEnv[Any]) -> None:
    observation, info = env.reset(seed=7)
    assert not info["is_success"]
    for action in random_actions(9, 40):
        assert env.observation_space.contains(observation)
        assert observation["achieved_goal"].shape == env.episode().canonical_cloud.shape
        for name, kind in INFO.items():
            assert type(info[name]) is kind, name
        assert 0.0 <= info["complete_rate"] <= 1.0
        assert info["is_success"] == (info["complete_rate"] == 1.0)
        assert info["buffer_overflows"] == 0
        observation, reward, terminated, truncated, info = env.step(action)
        assert type(reward) is float
        assert (terminated, truncated) == (False, False)


def test_writing_into_what_was_handed_out_changes_nothing(env: ContactEnv[Any]) -> None:
    expected = digest([env.reset(seed=8)[0], *play(env, random_actions(10, 5))])
    seen = [env.reset(seed=8)]
    found = []
    episode = env.episode(oracle=True)
    for action in [*random_actions(10, 5), None]:
        observation, info = seen.pop()
        found.append({name: value.copy() for name, value in observation.items()})  # type: ignore
        values = [*observation.values(), *info.values(), episode.canonical_cloud]
        for value in [*values, episode.gripper_spheres, env.snapshot().physics]:
            if isinstance(value, np.ndarray):
                value[...] = 1e9
        if action is not None:
            given = action.copy()
            result = env.step(given)
            np.testing.assert_array_equal(given, action)
            seen.append((result[0], result[4]))
    assert digest(found) == expected  # type: ignore[arg-type]


def test_experts_actions_solve_the_episode_as_the_oracle_says(env: ContactEnv[Any]) -> None:
    wrapped = gym.make(env.task.env_id, split="test")
    observation, info = wrapped.reset(seed=9)
    oracle = wrapped.unwrapped.episode(oracle=True).oracle  # type: ignore[attr-defined]
    np.testing.assert_array_equal(observation["achieved_goal"], oracle.points[0])
    terminated = truncated = False
    for action, points in zip(oracle.actions, oracle.points[1:], strict=True):
        assert not truncated
        # Where success is a distance to the goal, the way's end is within it before it is reached.
        assert not terminated or info["is_success"]
        observation, reward, terminated, truncated, info = wrapped.step(action)
        np.testing.assert_array_equal(observation["achieved_goal"], points)
    assert (reward, terminated, info["is_success"]) == (0.0, True, True)
    assert info["complete_rate"] == 1.0
    np.testing.assert_array_equal(observation["achieved_goal"], observation["desired_goal"])
    # Stepping on is allowed: the episode simply goes on.
    assert wrapped.observation_space.contains(wrapped.step(np.zeros(3, np.float32))[0])
    wrapped.close()


def test_episode_is_truncated_at_its_budget(env: ContactEnv[Any]) -> None:
    wrapped = gym.make(env.task.env_id, split="test")
    wrapped.reset(seed=0)
    budget = wrapped.unwrapped.episode().max_steps  # type: ignore[attr-defined]
    ends = [wrapped.step(np.zeros(3, np.float32))[2:4] for _ in range(budget)]
    assert ends == [(False, False)] * (budget - 1) + [(False, True)]
    wrapped.close()


def test_gymnasium_checker_finds_nothing(env: ContactEnv[Any]) -> None:
    from gymnasium.utils.env_checker import check_env

    fresh = gym.make(env.task.env_id, split="test").unwrapped
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(fresh, skip_render_check=True)
    fresh.close()
    assert [str(w.message) for w in caught] == []


def test_stable_baselines_checker_finds_nothing(env: ContactEnv[Any]) -> None:
    from stable_baselines3.common.env_checker import check_env

    fresh = make(env.task.env_id)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(fresh)
    fresh.close()
    # A cloud is neither a picture nor a vector, and SB3 would rather have one of these.
    advice = "unconventional shape"
    assert [str(w.message) for w in caught if advice not in str(w.message)] == []


@pytest.mark.parametrize(
    "options",
    [
        {"split": "tset"},
        {"split": 1},
        {"reward_type": "spares"},
        {"camera": "tpo"},
        {"render_mode": "rgb_aray"},
    ],
)
@pytest.mark.filterwarnings("ignore:.*render_modes")
def test_wrong_value_of_an_option_is_answered_with_the_right_ones(
    env: ContactEnv[Any], options: dict[str, Any]
) -> None:
    with pytest.raises(InvalidOptionError, match="valid: '") as caught:
        make(env.task.env_id, **options)
    (name, value), message = next(iter(options.items())), str(caught.value)
    assert name in message
    assert repr(value) in message


def test_misspelt_option_and_id_are_named(env: ContactEnv[Any]) -> None:
    with pytest.raises(TypeError, match="spilt"):
        gym.make(env.task.env_id, spilt="test")
    with pytest.raises(gym.error.NameNotFound, match="Did you mean"):
        gym.make(env.task.env_id.replace("ICD", "ICDD"))


def test_vector_env_and_spec_make_the_same_environment(env: ContactEnv[Any]) -> None:
    wrapped = gym.make(env.task.env_id, split="test")
    assert wrapped.spec is not None
    again = gym.make(gym.envs.registration.EnvSpec.from_json(wrapped.spec.to_json()))
    vector = gym.make_vec(env.task.env_id, num_envs=2, split="test")
    alone = [digest([wrapped.reset(seed=seed)[0]]) for seed in (1, 2)]
    assert digest([again.reset(seed=1)[0]]) == alone[0]
    batch, _ = vector.reset(seed=[1, 2])
    each = [{name: value[i] for name, value in batch.items()} for i in range(2)]
    assert [digest([observation]) for observation in each] == alone  # type: ignore[list-item]
    for made in (wrapped, again, vector):
        made.close()
