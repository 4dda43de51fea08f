"""What users and libraries may expect of every environment."""

from __future__ import annotations

import pickle
import subprocess
import sys
import warnings
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import bare, digest, make, play, random_actions, remake

VECTOR = random_actions(12, 3)
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
    wrapped = remake(env)
    if env.obs_mode == "partial":
        wrapped = remake(env, obs_mode="full")  # the clouds to compare with
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
    ends = env.episode().ends_on_success
    assert (reward, terminated, info["is_success"]) == (0.0, ends, True)
    assert info["complete_rate"] == 1.0
    np.testing.assert_array_equal(observation["achieved_goal"], oracle.points[-1])
    # Stepping on is allowed: the episode simply goes on.
    assert wrapped.observation_space.contains(wrapped.step(np.zeros(3, np.float32))[0])
    wrapped.close()


def test_goal_is_the_experts_last_cloud_in_the_scene_it_was_specified_in(
    env: ContactEnv[Any],
) -> None:
    observation, info = env.reset(seed=9)
    episode = env.episode(oracle=True)
    assert episode.oracle is not None
    assert episode.goal_oracle is not None
    np.testing.assert_array_equal(observation["desired_goal"], episode.goal_oracle.points[-1])
    elsewhere = "Adaptation" in env.task.env_id
    assert (episode.goal_oracle is not episode.oracle) == elsewhere
    for name in env.task.parameter_names:
        assert np.array_equal(info[name], info[f"goal_{name}"]) != elsewhere
    if env.obs_mode == "full":
        assert np.array_equal(observation["scene"], observation["goal_scene"]) != elsewhere
    assert env.episode().oracle is None
    assert env.episode().goal_oracle is None


def test_every_step_of_a_whole_episode_counts_toward_its_budget() -> None:
    made = gym.make("ICDNotebookFolding-v0")
    made.reset(seed=0)
    ends = [made.step(np.zeros(3, np.float32))[2:4] for _ in range(150)]
    assert ends == [(False, False)] * 149 + [(False, True)]
    made.close()


def test_spec_tells_the_budget(env: ContactEnv[Any]) -> None:
    assert env.spec is not None
    assert env.spec.max_episode_steps == env.episode().max_steps == env.task.max_steps
    again = gym.make(env.spec)
    assert bare(again).task == env.task
    assert bare(again).obs_mode == env.obs_mode
    again.close()


@pytest.mark.parametrize("change", [-90, 2])
def test_another_budget_is_the_environments_own(env: ContactEnv[Any], change: int) -> None:
    budget = env.task.max_steps + change
    first = remake(env, max_episode_steps=budget)
    assert first.spec is not None
    for made in (first, gym.make(first.spec)):
        assert made is made.unwrapped, "TimeLimit is left around it"
        made.reset(seed=0)
        state = bare(made).snapshot()
        assert made.spec == first.spec
        assert first.spec.max_episode_steps == bare(made).episode().max_steps == budget
        bare(made).restore(replace(state, steps=budget - 3))
        assert [made.step(np.zeros(3))[3] for _ in range(3)] == [False, False, True]
        bare(made).restore(state)
        assert made.step(np.zeros(3))[3] is False
        made.close()


def test_vectors_of_environments_take_a_budget(env: ContactEnv[Any]) -> None:
    assert env.spec is not None
    vector = gym.make_vec(env.spec.id, 1, max_episode_steps=2, **env.spec.kwargs)
    vector.reset(seed=0)
    assert [bool(vector.step(np.zeros((1, 3), np.float32))[3][0]) for _ in range(2)] == [0, 1]
    vector.close()


def test_restored_state_brings_the_steps_taken_with_it_up_to_the_budget(
    env: ContactEnv[Any],
) -> None:
    state = env.snapshot()
    env.restore(replace(state, steps=env.task.max_steps - 2))
    ends = [env.step(np.zeros(3, np.float32))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, True), (False, True)]
    env.restore(state)


def test_gymnasium_checker_finds_nothing(env: ContactEnv[Any]) -> None:
    from gymnasium.utils.env_checker import check_env

    fresh = remake(env).unwrapped
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(fresh, skip_render_check=True)
    fresh.close()
    assert [str(w.message) for w in caught] == []


def test_stable_baselines_checker_finds_nothing(env: ContactEnv[Any]) -> None:
    from stable_baselines3.common.env_checker import check_env

    fresh = remake(env).unwrapped
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
        {"obs_mode": "partail"},
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


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("spilt", "split"),
        ("rewardtype", "reward_type"),
        ("obsmode", "obs_mode"),
        ("render_mod", "render_mode"),
        ("max_episodes_steps", "max_episode_steps"),
    ],
)
def test_misspelt_option_is_answered_with_the_right_one(
    env: ContactEnv[Any], wrong: str, right: str
) -> None:
    for make_it in (gym.make, gym.make_vec):
        with pytest.raises(InvalidOptionError, match=f"did you mean '{right}'"):
            make_it(env.task.env_id, **{wrong: "test"})
    with pytest.raises(TypeError, match=wrong):
        type(env)(**{wrong: "test"})


def test_misspelt_id_is_answered_with_the_right_one(env: ContactEnv[Any]) -> None:
    with pytest.raises(gym.error.NameNotFound, match=f"Did you mean: `{env.task.env_id[:-3]}`"):
        gym.make(env.task.env_id.replace("ICD", "ICDD"))
    with pytest.raises(gym.error.VersionNotFound, match="`v0`"):
        gym.make(env.task.env_id.replace("v0", "v99"))


def test_ids_are_known_once_the_package_is_imported_or_named() -> None:
    code = """
import gymnasium as gym
try:
    gym.make("ICDCableRouting-v0")
except gym.error.NameNotFound:
    print("unknown")
print(gym.make("icd_envs:ICDCableRouting-v0").spec.id)
from icd_envs import ENV_IDS
print(*(gym.make(env_id).spec.id for env_id in ENV_IDS))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["unknown", "ICDCableRouting-v0", *ENV_IDS]


def test_spec_survives_json_and_pickle(env: ContactEnv[Any]) -> None:
    spec = env.spec
    assert spec is not None
    copied = gym.envs.registration.EnvSpec.from_json(spec.to_json())
    assert copied == spec == pickle.loads(pickle.dumps(spec))
    again = gym.make(copied)
    assert again.spec == spec
    assert digest([again.reset(seed=1)[0]]) == digest([env.reset(seed=1)[0]])
    again.close()


@pytest.fixture(scope="module")
def alone(env: ContactEnv[Any]) -> list[str]:
    """What each seed shows with the fixed actions of ``VECTOR``."""
    seeds = range(1, 3)
    return [digest([env.reset(seed=seed)[0], *play(env, VECTOR)]) for seed in seeds]


@pytest.mark.parametrize(
    ("mode", "count", "settings"),
    # Processes of their own take a second each to start.
    [("sync", 2, {}), ("async", 1, {"context": "spawn"})],
)
def test_vector_env_holds_the_same_environments(
    env: ContactEnv[Any], alone: list[str], mode: str, count: int, settings: dict[str, Any]
) -> None:
    assert env.spec is not None
    vector = gym.make_vec(
        env.spec.id, count, vectorization_mode=mode, vector_kwargs=settings, **env.spec.kwargs
    )
    batches = [vector.reset(seed=1)[0]]
    batches += [vector.step(np.repeat(action[None], count, axis=0))[0] for action in VECTOR]
    vector.close()
    each: Any = [[{n: v[i] for n, v in batch.items()} for batch in batches] for i in range(count)]
    assert [digest(observations) for observations in each] == alone[:count]
