"""The reachability-aware point cloud autoencoder."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from icd_agent.latent.autoencoder import Decoder, Encoder
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.reachability import Reachability


class LatentModel(nn.Module):
    """Features of an object's points <-> a short vector, and distances between vectors in steps.

    Features are made zero-mean per dimension and divided by one number for all dimensions:
    dividing each by its own would blow up those that hardly vary.
    """

    mean: Tensor
    scale: Tensor

    def __init__(
        self, config: LatentConfig, mean: Tensor | None = None, scale: float = 1.0
    ) -> None:
        """Build the layers.

        Args:
            config: sizes.
            mean: (D,) of the training states' features; None while weights are loaded.
            scale: root mean square of what is left.
        """
        super().__init__()
        self.config = config
        self.encoder = Encoder(config)
        self.decoder = Decoder(config)
        self.reachability = Reachability(config)
        self.register_buffer("mean", torch.zeros(config.features) if mean is None else mean)
        self.register_buffer("scale", torch.tensor(float(scale)))

    def normalise(self, features: Tensor) -> Tensor:
        """(..., N, D) as the cost space has them -> as the network has them."""
        return (features - self.mean) / self.scale

    def encode(self, features: Tensor, canonical: Tensor) -> Tensor:
        """Latents (B, Z) of object states.

        Args:
            features: (B, N, D) of the cost space.
            canonical: (N, 3) [m] the object in its rest frame.
        """
        mean: Tensor = self.encoder(self.normalise(features), canonical)[0]
        return mean

    def decode(self, latents: Tensor, canonical: Tensor) -> Tensor:
        """(B, Z) -> features (B, N, D) of the cost space."""
        decoded: Tensor = self.decoder(latents, canonical) * self.scale + self.mean
        return decoded
