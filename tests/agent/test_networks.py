"""Networks that were not trained on one another are refused, before or when they first meet."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from benchmarks.registry import Offer, make_agent
from icd_agent.agent import ICDAgent
from icd_agent.chain import WithPlaces
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.config import ChainConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.diffusion.generate import Generator
from icd_agent.field.space import ExactFieldSpace
from icd_agent.networks import check_fit, load_networks, one_field, save_networks
from icd_envs.errors import CheckpointError, InvalidOptionError
from tests.agent.field.small import SMALL, small_field
from tests.agent.test_icd_agent import DENOISER, FEATURES, LATENT, actions, networks
from tests.envs.making import CABLE


@pytest.mark.parametrize(("name", "value"), [("scene_size", 0.5), ("points", 100)])
def test_a_denoiser_of_other_scenes_or_objects_is_refused(
    tmp_path: Path, name: str, value: float
) -> None:
    other = Denoiser(replace(DENOISER, **{name: value})).eval()  # type: ignore[arg-type]
    misfit = networks()._replace(diffusion=other)
    told = f"{name}={getattr(LATENT, name)} of the autoencoder, but {name}={value} of the denoiser"
    with pytest.raises(CheckpointError, match=told):
        check_fit(misfit)
    save_networks(misfit, tmp_path)
    with pytest.raises(CheckpointError, match=told):
        load_networks(tmp_path)


def test_agents_of_one_field_refuse_two_and_another(tmp_path: Path) -> None:
    local = networks()
    assert one_field(local, "local") is local
    with pytest.raises(CheckpointError, match=r"'global' is wanted, .* 'local': .*--scope global"):
        one_field(local, "global")
    save_networks(local._replace(whole=small_field(1)), tmp_path)
    for name in ("icd-local", "icd-paper", "global-ndf", "global-ndf-paper"):
        with pytest.raises(CheckpointError, match="use weights trained on one field"):
            make_agent(f"{name}@{tmp_path}", Offer(CABLE))


@pytest.mark.parametrize("reachable", [1e-3, 5.0])
def test_what_no_pair_can_be_predicted_within_is_refused(reachable: float) -> None:
    found = networks()
    with pytest.raises(InvalidOptionError, match=f"reachable={reachable} .* more than 5 control"):
        Generator(found.diffusion, found.latent, ChainConfig(reachable=reachable))
    for within in (5.1, None):
        Generator(found.diffusion, found.latent, ChainConfig(reachable=within))


def test_a_space_of_other_features_is_refused_and_places_beside_them_are_left_out() -> None:
    found = networks()
    generator = Generator(found.diffusion, found.latent, ChainConfig())
    source = DiffusedSource(found.field, found.latent, generator)
    env: Any = gym.make(CABLE).unwrapped
    observation, _ = env.reset(seed=3)
    chains = []
    for width, places in ((FEATURES, 0.0), (FEATURES, 0.2), (FEATURES + 3, 0.0)):
        field = found.field if width == FEATURES else small_field(1, replace(SMALL, descriptor=11))
        space = ExactFieldSpace(field)
        placed = (WithPlaces(space, places) if places else space).place(observation)
        rng = np.random.default_rng(0)
        if width == FEATURES:
            chains.append(source.chain(env.episode(), observation, placed, rng))
        else:
            with pytest.raises(CheckpointError, match=r"by 11 numbers, .* trained on 8"):
                source.chain(env.episode(), observation, placed, rng)
    env.close()
    assert (chains[0].features == chains[1].features[..., :FEATURES]).all()


def test_an_agent_tells_how_many_steps_its_chain_is_predicted_to_take() -> None:
    env: gym.Env[Any, Any] = gym.make(CABLE)
    agent = ICDAgent(networks())
    actions(agent, env, steps=1)
    info = agent.plan_info
    assert info is not None
    assert info.steps is not None
    assert info.steps.shape == (info.chain_length,)
    assert (info.steps >= LATENT.bin_steps / 2).all()
    env.close()
