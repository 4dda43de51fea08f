"""Stable-Baselines3 learns on our environments without an adapter of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import gymnasium as gym
import numpy as np
import pytest
import torch

from baselines.point_net import PointNetExtractor
from icd_envs import ENV_IDS
from icd_envs.wrappers import FlattenPointCloud, SubsamplePointCloud

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm


def tiny(**more: object) -> dict[str, object]:
    """Policy settings, which SB3 writes into."""
    return {"net_arch": [16], **more}


def tiny_point_net() -> dict[str, object]:
    return tiny(
        features_extractor_class=PointNetExtractor,
        features_extractor_kwargs={"points": 20, "widths": (8, 16)},
    )


def small(env_id: str) -> SubsamplePointCloud:
    """Few points and short episodes, so that hindsight has several to relabel."""
    return SubsamplePointCloud(gym.make(env_id, max_episode_steps=40), 20, 20)


def assert_learns(model: BaseAlgorithm, steps: int) -> None:
    """Every weight is another number after learning, and still a number."""
    before = {name: value.clone() for name, value in model.policy.state_dict().items()}
    model.learn(steps)
    assert model.num_timesteps == steps
    for name, value in model.policy.state_dict().items():
        assert torch.isfinite(value).all(), name
        assert not torch.equal(value, before[name]), name


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_sac_with_hindsight_trains_for_300_steps(env_id: str) -> None:
    from stable_baselines3 import SAC, HerReplayBuffer

    model = SAC(
        "MultiInputPolicy",
        small(env_id),
        replay_buffer_class=HerReplayBuffer,
        replay_buffer_kwargs={"copy_info_dict": True},
        policy_kwargs=tiny_point_net(),
        learning_starts=100,
        batch_size=16,
        buffer_size=300,
        seed=0,
    )
    assert_learns(model, 300)
    buffer = model.replay_buffer
    assert isinstance(buffer, HerReplayBuffer)
    rewards = buffer.sample(256).rewards.numpy()
    assert set(np.unique(rewards)) == {-1.0, 0.0}  # relabelled goals are reached
    model.env.close()


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_ppo_trains_on_the_flat_vector(env_id: str) -> None:
    from stable_baselines3 import PPO

    model = PPO(
        "MlpPolicy", FlattenPointCloud(small(env_id)), n_steps=40, batch_size=40,
        policy_kwargs=tiny(), seed=0,
    )  # fmt: skip
    assert_learns(model, 80)
    model.env.close()
