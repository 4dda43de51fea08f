"""Which task is behind an id."""

from __future__ import annotations

import gymnasium as gym
import pytest

from icd_envs import ENV_IDS
from icd_envs.demonstrations import TASKS, find_task
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.env import ContactEnv


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_task_of_an_id_is_that_of_its_environment(env_id: str) -> None:
    env = gym.make(env_id).unwrapped
    assert isinstance(env, ContactEnv)
    assert find_task(env_id) == find_task(f"icd_envs:{env_id}") == env.task == TASKS[env_id]
    env.close()


@pytest.mark.parametrize(
    ("env_id", "message"),
    [
        ("ICDCableRoutin-v0", "did you mean 'ICDCableRouting-v0'.*of your own is module:ID"),
        ("no_such_module:Task-v0", "no_such_module"),
        ("icd_envs:NoSuchTask-v0", "NoSuchTask"),
        ("", "unknown environment id ''"),
        ("CartPole-v1", "CartPoleEnv, which has no task"),
    ],
)
def test_id_without_a_task_is_refused(env_id: str, message: str) -> None:
    with pytest.raises(InvalidOptionError, match=message):
        find_task(env_id)
