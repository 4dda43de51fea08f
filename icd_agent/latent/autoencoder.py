"""Point cloud encoder and decoder in the object's canonical coordinates."""

from __future__ import annotations

from itertools import pairwise
from typing import Final, NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from icd_agent.field.neighbours import gather, nearest, spread
from icd_agent.latent.config import LatentConfig

BEGIN: Final = -6.0
"""About what the logarithm of the variance is before training: what principal components say is
worth keeping from the first step on."""


class Parts(NamedTuple):
    """How a canonical cloud is divided.

    Attributes:
        members: (G, k) indices of the points of each part.
        offsets: (G, k, 3) their canonical places about the part's middle, in ``object_size``.
        middles: (G, 3) canonical places of the middles, in ``object_size``.
    """

    members: Tensor
    offsets: Tensor
    middles: Tensor


def divide(canonical: Tensor, config: LatentConfig) -> Parts:
    """Divide a canonical cloud (N, 3) [m]: parts overlap and cover it."""
    cloud = canonical[None]
    there = torch.ones(cloud.shape[:2], dtype=torch.bool, device=cloud.device)
    middles = gather(cloud, spread(cloud, min(config.groups, cloud.shape[1]), there))
    _, members = nearest(middles, cloud, min(config.neighbours, cloud.shape[1]))
    offsets = gather(cloud, members) - middles[:, :, None]
    return Parts(members[0], offsets[0] / config.object_size, middles[0] / config.object_size)


class Encoder(nn.Module):
    """PointNet++: parts first, then the whole.

    Parts are formed in canonical coordinates: grouping in world coordinates would tell the latent
    where the object is, not only what it touches.
    """

    def __init__(self, config: LatentConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.config = config
        width = config.width
        self.part = _perceptron(config.features + 3, width, 2 * width)
        self.whole = _perceptron(2 * width + 3, 2 * width, 4 * width)
        self.out = nn.Linear(8 * width, 2 * config.latent)
        self._divided: tuple[Tensor, Parts] | None = None

    def forward(self, features: Tensor, canonical: Tensor) -> tuple[Tensor, Tensor]:
        """What is added to the linear latent, and the logarithm of the variance.

        Args:
            features: (B, N, D), normalised.
            canonical: (N, 3) [m] the object in its rest frame, same point order.

        Returns:
            (B, Z) each.
        """
        parts = self._divide(canonical)
        members = features[:, parts.members]
        offsets = parts.offsets.expand(len(features), -1, -1, -1)
        told = self.part(torch.cat([members, offsets], dim=-1)).amax(dim=2)
        middles = parts.middles.expand(len(features), -1, -1)
        whole = self.whole(torch.cat([told, middles], dim=-1))
        pooled = torch.cat([whole.amax(dim=1), whole.mean(dim=1)], dim=-1)
        mean, log_variance = self.out(pooled).chunk(2, dim=-1)
        return mean, (log_variance + BEGIN).clamp(-20.0, 4.0)

    def _divide(self, canonical: Tensor) -> Parts:
        """Parts of a canonical cloud; those of the last one are kept, it is mostly the same."""
        last = self._divided
        if last is None or last[0].device != canonical.device or not last[0].equal(canonical):
            self._divided = last = canonical.clone(), divide(canonical, self.config)
        return last[1]


class Decoder(nn.Module):
    """Features of any canonical point, given the latent: six gated layers (Luo and Hu, 2021)."""

    def __init__(self, config: LatentConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.config = config
        width = config.decoder_width
        widths = [3, width, 2 * width, 4 * width, 2 * width, width, config.features]
        self.layers = nn.ModuleList(_ConcatSquash(a, b, config.latent) for a, b in pairwise(widths))

    def forward(self, latents: Tensor, canonical: Tensor) -> Tensor:
        """(B, Z) and (N, 3) [m] -> (B, N, D), normalised."""
        values = (canonical / self.config.object_size).expand(len(latents), -1, -1)
        for layer in self.layers[:-1]:
            values = functional.leaky_relu(layer(values, latents))
        decoded: Tensor = self.layers[-1](values, latents)
        return decoded


class _ConcatSquash(nn.Module):
    """(W x + b) * sigmoid(G z + g) + H z."""

    def __init__(self, inputs: int, outputs: int, latent: int) -> None:
        super().__init__()
        self.layer = nn.Linear(inputs, outputs)
        self.gate = nn.Linear(latent, outputs)
        self.shift = nn.Linear(latent, outputs, bias=False)

    def forward(self, values: Tensor, latents: Tensor) -> Tensor:
        gate, shift = torch.sigmoid(self.gate(latents)), self.shift(latents)
        out: Tensor = self.layer(values) * gate[:, None] + shift[:, None]
        return out


def _perceptron(inputs: int, width: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, width), nn.SiLU(), nn.Linear(width, width), nn.SiLU(),
        nn.Linear(width, outputs),
    )  # fmt: skip
