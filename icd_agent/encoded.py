"""Object states through the autoencoder and back."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from icd_agent.chain import Placed, Subgoals, SubgoalSource
from icd_agent.latent.model import LatentModel
from icd_envs.api import Episode, Float32Array, FloatArray, Observation


def encode(latent: LatentModel, features: FloatArray, canonical: FloatArray) -> Tensor:
    """Latents (B, Z) of object states.

    Args:
        latent: in evaluation mode.
        features: (B, N, D) of the cost space.
        canonical: (N, 3) [m] the object in its rest frame.
    """
    with torch.no_grad():
        return latent.encode(_tensor(features), _tensor(canonical))


def decode(latent: LatentModel, latents: Tensor, canonical: FloatArray) -> Float32Array:
    """(B, Z) -> features (B, N, D) of the cost space."""
    with torch.no_grad():
        found: Float32Array = latent.decode(latents, _tensor(canonical)).numpy()
    return found


class EncodedSource:
    """Another source's subgoals as the autoencoder gives them back.

    What is lost on the way is lost to everything that is generated in latents.
    """

    def __init__(self, source: SubgoalSource, latent: LatentModel) -> None:
        """Put together.

        Args:
            source: of the subgoals.
            latent: in evaluation mode, trained on features of the cost space.
        """
        self.needs_oracle = source.needs_oracle
        self._source = source
        self._latent = latent

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Return the other source's subgoals, encoded and decoded; so is where they begin."""
        given = self._source.chain(episode, observation, space, rng)
        now = space.here(observation["achieved_goal"])
        canonical = episode.canonical_cloud
        latents = encode(self._latent, np.concatenate([now[None], given.features]), canonical)
        found = decode(self._latent, latents, canonical)
        return Subgoals(found[1:], given.clouds, found[0])


def _tensor(values: FloatArray) -> Tensor:
    return torch.from_numpy(np.ascontiguousarray(values, np.float32))
