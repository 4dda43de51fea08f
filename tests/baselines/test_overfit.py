"""Policies reproduce a handful of clean episodes: a low score in test scenes is a finding, no bug.

Slow: ``pytest -m slow tests/baselines/test_overfit.py`` takes about five minutes a policy.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import pytest

import icd_envs  # noqa: F401  registers our ids
from benchmarks.collect import collect
from benchmarks.executors import InProcess
from benchmarks.train_policy import policy_config
from icd_agent.field.train import load_field
from icd_agent.policy.agent import ChunkAgent
from icd_agent.policy.data import PolicyData
from icd_agent.policy.look import Look
from icd_agent.policy.policy import load_policy
from icd_agent.policy.train import train_policy
from icd_agent.training.config import TrainingConfig
from icd_agent.weights import DIFFUSION_POLICY, DP3, LOCAL_FIELD, shipped_folder
from icd_envs.demonstrations import Demonstrations, find_task
from icd_envs.demonstrations.header import Header
from tests.envs.making import CABLE

EPISODES = 5
WANTED = 5
"""Of five, 90 % are all."""


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("env_id", [CABLE, "ICDNotebookFolding-v0"])
@pytest.mark.parametrize("name", [DIFFUSION_POLICY, DP3])
def test_it_solves_the_scenes_of_clean_episodes_that_it_has_learned(
    name: str, env_id: str, tmp_path: Path
) -> None:
    steps = find_task(env_id).max_steps
    header = Header(env_id=env_id, noisy=False, seed=5, steps=steps, episodes=EPISODES)
    collect(header, tmp_path / "data", InProcess())
    recorded = Demonstrations(tmp_path / "data")
    assert recorded.success.all()
    field = load_field(shipped_folder(env_id, LOCAL_FIELD)) if name == DIFFUSION_POLICY else None
    config = policy_config(name, 0 if field is None else field.config.descriptor)
    look = Look(config, field)
    data = PolicyData(recorded, look, config, episodes=EPISODES, solved_only=False)
    training = TrainingConfig(steps=1000, learning_rate=1e-3, weight_decay=1e-6)
    train_policy(data, config, training, tmp_path / "policy", about={})
    agent = ChunkAgent(load_policy(tmp_path / "policy"), field)
    env = gym.make(env_id, split="train")
    solved = sum(_solves(agent, env, int(seed)) for seed in recorded.seeds)
    env.close()
    assert solved >= WANTED


def _solves(agent: ChunkAgent, env: gym.Env[Any, Any], seed: int) -> bool:
    observation, info = env.reset(seed=seed)
    unwrapped: Any = env.unwrapped
    agent.reset(unwrapped.episode(), seed=0)
    ended = False
    while not ended:
        observation, _, terminated, truncated, info = env.step(agent.act(observation))
        ended = terminated or truncated
    return bool(info["is_success"])
