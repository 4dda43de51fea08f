"""A chain through the autoencoder and back is the same chain, less what the autoencoder loses."""

from __future__ import annotations

import numpy as np
import torch

from icd_agent.chain import GoalSource, Placed, Subgoals
from icd_agent.encoded import EncodedSource, decode, encode
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.training.initial import initialise
from icd_envs.api import Episode, Observation
from tests.agent.toy_world import ToyWorld

CONFIG = LatentConfig(3, 3, 5, latent=6, groups=4, neighbours=3, width=8, decoder_width=8)
RNG = np.random.default_rng(0)


def model() -> LatentModel:
    latent = LatentModel(CONFIG).eval()
    initialise(latent, torch.Generator().manual_seed(0))
    return latent


class Given:
    """Two goals one after the other, and a claim to the oracle."""

    needs_oracle = True

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        goal = GoalSource().chain(episode, observation, space, rng)
        assert goal.clouds is not None
        clouds = np.concatenate([goal.clouds / 2, goal.clouds])
        return Subgoals(space.here(clouds), clouds)


def test_every_subgoal_and_the_beginning_are_what_the_autoencoder_says() -> None:
    world, latent = ToyWorld(goal=(0.3, 0.0, 0.0)), model()
    episode, observation = world.episode(), world.observation()
    space = Placed(lambda points: 2.0 * points, lambda points: 3.0 * points)
    found = EncodedSource(Given(), latent).chain(episode, observation, space, RNG)
    given = Given().chain(episode, observation, space, RNG)
    canonical = episode.canonical_cloud

    def through(features: np.ndarray) -> np.ndarray:
        return decode(latent, encode(latent, features[None], canonical), canonical)[0]

    assert len(found.features) == 2
    for subgoal, before in zip(found.features, given.features, strict=True):
        np.testing.assert_allclose(subgoal, through(before), rtol=1e-5, atol=1e-6)
    assert found.begin is not None
    now = 2.0 * observation["achieved_goal"]
    np.testing.assert_allclose(found.begin, through(now), rtol=1e-5, atol=1e-6)
    assert found.clouds is not None
    np.testing.assert_array_equal(found.clouds, given.clouds)


def test_it_needs_what_the_other_source_needs() -> None:
    assert EncodedSource(Given(), model()).needs_oracle
    assert not EncodedSource(GoalSource(), model()).needs_oracle
