"""The example in docs/reinforcement-learning.md runs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.wrappers import SubsamplePointCloud
from tests.envs.making import make, random_actions

PAGE = (Path(__file__).parents[2] / "docs" / "reinforcement-learning.md").read_text("utf-8")

SHORTER = {
    "learning_starts=1_000": "learning_starts=300",
    "buffer_size=50_000": "buffer_size=400, batch_size=16",
    "model.learn(60_000)": "model.learn(305); print(model.num_timesteps, model._n_updates)",
}


def test_example_learns_for_a_few_steps() -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    for long, short in SHORTER.items():
        assert code.count(long) == 1, long
        code = code.replace(long, short)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=240
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["305", "5"]


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_relabelled_goals_tell_something_in_notebook_folding_only(env_id: str) -> None:
    env = make(env_id)
    env.reset(seed=0)
    steps = [env.step(action) for action in random_actions(0, 40)]
    clouds = np.stack([step[0]["achieved_goal"] for step in steps])
    infos = [step[4] for step in steps]
    now, later = np.triu_indices(len(steps))
    rewards = env.compute_reward(clouds[now], clouds[later], [infos[i] for i in now])
    assert set(rewards) == ({0.0, -1.0} if env_id == "ICDNotebookFolding-v0" else {0.0})
    env.close()


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_size_of_a_transition_is_as_told(env_id: str) -> None:
    full = gym.make(env_id)
    for env, told in ((full, "58 kB"), (SubsamplePointCloud(full, 50, 128), "8.6 kB")):
        assert isinstance(env.observation_space, gym.spaces.Dict)
        size = 2 * sum(space.sample().nbytes for space in env.observation_space.values())
        assert f"{size / 1e3:.2g} kB" == told
        assert told in PAGE
    full.close()
