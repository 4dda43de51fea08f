"""SAC with hindsight in a partial view: what is hidden has no influence."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

from baselines.sac_her import Actor, ActorAgent, ActorConfig
from icd_agent.training.initial import initialise
from icd_envs.errors import EpisodeStateError, InvalidObservationError
from tests.envs.making import CABLE

CONFIG = ActorConfig(object_points=32, scene_points=64, point_widths=(16, 32), widths=(32,))


def made_agent() -> ActorAgent:
    actor = Actor(CONFIG).eval()
    initialise(actor, torch.Generator().manual_seed(0))
    return ActorAgent(actor)


def begun(obs_mode: str) -> tuple[ActorAgent, dict[str, Any]]:
    env: Any = gym.make(CABLE, obs_mode=obs_mode).unwrapped
    observation, _ = env.reset(seed=3)
    agent = made_agent()
    agent.reset(env.episode(), seed=0)
    env.close()
    return agent, observation


def test_points_that_are_hidden_may_be_said_to_be_anywhere() -> None:
    agent, observation = begun("partial")
    other, _ = begun("partial")
    elsewhere = dict(observation)
    for name in ("achieved_goal", "scene"):
        observation[f"{name}_mask"][10:60] = 0
        hidden = observation[f"{name}_mask"][:, None] == 0
        for where, said in ((observation, 0.0), (elsewhere, 9.0)):
            where[name] = np.where(hidden, np.float32(said), observation[name])
    action = agent.act(observation)  # type: ignore[arg-type]
    np.testing.assert_array_equal(other.act(elsewhere), action)  # type: ignore[arg-type]
    assert np.abs(action).max() > 1e-4


def test_a_full_view_is_acted_on_as_it_is() -> None:
    agent, observation = begun("full")
    clouds = {}
    for name in ("achieved_goal", "desired_goal", "goal_scene", "scene"):
        cloud = observation[name]
        count = 64 if "scene" in name else 32
        kept = np.linspace(0, len(cloud) - 1, count).round().astype(int)
        clouds[name] = torch.from_numpy(cloud[kept])[None]
    with torch.no_grad():
        expected = agent.actor(clouds, torch.from_numpy(observation["observation"])[None])[0]
    np.testing.assert_array_equal(agent.act(observation), expected.numpy())  # type: ignore[arg-type]


def test_what_cannot_be_acted_on_is_named() -> None:
    agent, observation = begun("partial")
    blind = {**observation, "scene_mask": np.zeros_like(observation["scene_mask"])}
    with pytest.raises(InvalidObservationError, match="scene_mask is 0 everywhere"):
        agent.act(blind)  # type: ignore[arg-type, typeddict-item]
    with pytest.raises(EpisodeStateError, match=r"call reset\(episode, seed\) first"):
        made_agent().act(observation)  # type: ignore[arg-type]
