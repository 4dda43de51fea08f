"""Models of Stable-Baselines3 as agents."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
import pytest

from benchmarks.registry import Offer, make_agent
from icd_envs import ENV_IDS
from icd_envs.api import Agent
from icd_envs.errors import InvalidOptionError
from icd_envs.wrappers import FlattenPointCloud, SubsamplePointCloud

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

ENV_ID = ENV_IDS[0]


def few(env: gym.Env[Any, Any]) -> gym.Env[Any, Any]:
    return SubsamplePointCloud(env, 20, 30)


def flat(env: gym.Env[Any, Any]) -> gym.Env[Any, Any]:
    return FlattenPointCloud(SubsamplePointCloud(env))


def saved(name: str, env: gym.Env[Any, Any], path: Path) -> BaseAlgorithm:
    """An untrained model of that algorithm, on disk."""
    import stable_baselines3 as sb3

    policy = (
        "MlpPolicy" if isinstance(env.observation_space, gym.spaces.Box) else "MultiInputPolicy"
    )
    more: dict[str, Any] = {}
    if name in ("SAC", "TD3", "DDPG"):
        more = {"buffer_size": 10}
    if name == "SAC":
        more |= {"replay_buffer_class": sb3.HerReplayBuffer} if policy != "MlpPolicy" else {}
    net = {"net_arch": [8]}
    model = getattr(sb3, name)(policy, env, policy_kwargs=net, seed=0, device="cpu", **more)
    model.save(path)
    return model


def load(path: Path, env_id: str = ENV_ID) -> Agent:
    return make_agent(f"sb3:{path}", Offer(env_id, trust_pickle=True))


@pytest.mark.parametrize(
    ("name", "wrap"),
    [
        ("SAC", few), ("PPO", few), ("A2C", few), ("TD3", few), ("DDPG", few),
        ("SAC", flat), ("PPO", FlattenPointCloud), ("SAC", lambda env: env),
    ],
)  # fmt: skip
def test_agent_acts_as_the_model_in_its_wrapped_environment(
    name: str, wrap: Callable[[gym.Env[Any, Any]], gym.Env[Any, Any]], tmp_path: Path
) -> None:
    plain = gym.make(ENV_ID, split="test", max_episode_steps=10)
    wrapped = wrap(plain)
    model = saved(name, wrapped, tmp_path / "my model.zip")
    agent = load(tmp_path / "my model.zip")
    seen, _ = wrapped.reset(seed=3)
    observation = plain.unwrapped._copy_observation()
    agent.reset(None, 0)
    expected, _ = model.predict(seen, deterministic=True)
    assert np.array_equal(agent.act(observation), expected)
    assert agent.act(observation).shape == (3,)
    wrapped.close()


def test_model_of_another_environment_is_refused(tmp_path: Path) -> None:
    saved("PPO", gym.make("Pendulum-v1"), tmp_path / "model.zip")
    with pytest.raises(InvalidOptionError, match=r"trained on \(3,\), .*achieved_goal.*plug-in.md"):
        load(tmp_path / "model.zip")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 torn", b"no zip"])
def test_damaged_model_is_explained(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "model.zip").write_bytes(content)
    with pytest.raises(InvalidOptionError, match="no model of Stable-Baselines3"):
        load(tmp_path / "model.zip")
    with pytest.raises(InvalidOptionError, match="no model of Stable-Baselines3"):
        load(tmp_path / "missing.zip")
