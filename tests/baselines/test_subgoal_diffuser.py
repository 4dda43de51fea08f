"""Subgoal Diffuser: chains of places, in the frame their networks were trained in."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

from baselines.subgoal_diffuser import compose
from icd_agent.checkpoints import save_checkpoint
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.field.train import load_field
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.mppi.presets import PAPER
from icd_agent.scene_tokens import TOKENS
from icd_agent.training.initial import initialise
from icd_agent.weights import LOCAL_FIELD, shipped_folder
from tests.envs.making import CABLE


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With random weights: whatever they say, the agent must act on it."""
    out = tmp_path_factory.mktemp("networks")
    described = load_field(shipped_folder(CABLE, LOCAL_FIELD)).config.descriptor
    sizes = LatentConfig(3, described, 200, latent=8, groups=6, neighbours=4, width=16)
    config = DiffusionConfig(8, described, 200, TOKENS, places=0, width=32, layers=1, heads=2)
    for kind, network in (("latent", LatentModel(sizes)), ("diffusion", Denoiser(config))):
        initialise(network, torch.Generator().manual_seed(0))
        save_checkpoint(out / kind, kind, network, network.config, {}, half=True)
    return out


@pytest.fixture(params=[CABLE, "ICDCableRoutingAdaptation-v0"])
def env(request: pytest.FixtureRequest) -> Iterator[gym.Env[Any, Any]]:
    env = gym.make(request.param)
    yield env
    env.close()


@pytest.mark.parametrize("settings", ["paper", "improved"])
def test_it_plans_along_a_chain_that_ends_where_it_should(
    env: gym.Env[Any, Any], folder: Path, settings: str
) -> None:
    agent = compose(CABLE, folder, settings)
    assert (agent.mppi_config == PAPER) == (settings == "paper")  # its temperature is of metres
    observation, _ = env.reset(seed=3)
    unwrapped: Any = env.unwrapped
    episode = unwrapped.episode(simulator=True)
    agent.reset(episode, seed=1)
    action = agent.act(observation)
    assert action.shape == (3,)
    assert np.abs(action).max() <= 1
    info = agent.plan_info
    assert info is not None
    assert info.subgoals is not None
    off = np.linalg.norm(info.subgoals[-1] - observation["desired_goal"], axis=-1).max()
    # The paper in-paints a goal of another scene where it lies; otherwise it is generated.
    assert (off < 1e-5) == (settings == "paper" or not episode.foreign_goal)
