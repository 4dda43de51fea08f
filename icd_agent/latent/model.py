"""The reachability-aware point cloud autoencoder."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from icd_agent.latent.autoencoder import Decoder, Encoder
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.principal import Principal
from icd_agent.latent.reachability import Reachability
from icd_agent.options import require


class LatentModel(nn.Module):
    """Features of an object's points <-> a short vector, and distances between vectors in steps.

    The latent is made of the coefficients of principal components and of what PointNet++ adds to
    them; the decoder adds to the linear reconstruction what components cannot say. So the networks
    learn only what is not linear, and distances between latents are about those between features.
    """

    mean: Tensor
    scale: Tensor
    components: Tensor

    def __init__(self, config: LatentConfig, linear: Principal | None = None) -> None:
        """Build the layers.

        Args:
            config: sizes.
            linear: of the training states' features; None while weights are loaded.
        """
        super().__init__()
        self.config = config
        self.encoder = Encoder(config)
        self.decoder = Decoder(config)
        self.reachability = Reachability(config)
        shape = config.points, config.features
        if linear is None:
            mean, scale, components = torch.zeros(shape), 1.0, torch.zeros(config.latent, *shape)
        else:
            mean, scale = torch.from_numpy(linear.mean), linear.scale
            components = torch.from_numpy(linear.components)
        self.register_buffer("mean", mean)
        self.register_buffer("scale", torch.tensor(scale))
        self.register_buffer("components", components)

    def normalise(self, features: Tensor) -> Tensor:
        """(..., N, D) as the cost space has them -> as the network has them."""
        return (features - self.mean) / self.scale

    def distribution(self, values: Tensor, canonical: Tensor) -> tuple[Tensor, Tensor]:
        """Mean and logarithm of the variance of the latent, (B, Z) each.

        Args:
            values: (B, N, D), normalised.
            canonical: (N, 3) [m] the object in its rest frame.
        """
        added, log_variance = self.encoder(values, canonical)
        share = self.config.latent / self.config.points
        linear = share * values.flatten(1) @ self.components.flatten(1).T
        return linear + added, log_variance

    def reconstruct(
        self, latents: Tensor, canonical: Tensor, points: Tensor | slice = slice(None)
    ) -> Tensor:
        """(B, Z) -> normalised features (B, P, D) of the points with these indices."""
        components = self.components[:, points]
        linear = (latents @ components.flatten(1)).view(-1, *components.shape[1:])
        return linear + self.decoder(latents, canonical[points])

    def encode(self, features: Tensor, canonical: Tensor) -> Tensor:
        """Latents (B, Z) of object states.

        Args:
            features: (B, N, D) of the cost space.
            canonical: (N, 3) [m] the object in its rest frame.

        Raises:
            InvalidOptionError: another number of points, or of features, than it was trained with.
        """
        trained = self.config.points, self.config.features
        told = f"(B, {trained[0]}, {trained[1]}), points and features as trained"
        require(features.shape[1:] == trained, "features.shape", tuple(features.shape), told)
        require(len(canonical) == trained[0], "canonical", len(canonical), f"{trained[0]} points")
        return self.distribution(self.normalise(features), canonical)[0]

    def decode(self, latents: Tensor, canonical: Tensor) -> Tensor:
        """(B, Z) -> features (B, N, D) of the cost space."""
        return self.reconstruct(latents, canonical) * self.scale + self.mean
