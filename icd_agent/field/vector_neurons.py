"""Vector neurons: layers whose channels are 3-D vectors (Deng et al., 2021).

Vectors are (..., 3, C): the last axis holds the channels, so that a linear map of channels is an
ordinary one. Every layer here turns with its input under any rotation. A constant channel along
gravity, added by whoever calls, leaves the rotations about gravity only (the paper's SE(3)^z).
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

TINY = 1e-6


class VectorLinear(nn.Linear):
    """A linear map of channels, (..., 3, C) -> (..., 3, C'); no bias, which would not turn."""

    def __init__(self, inputs: int, outputs: int) -> None:
        """Initialise as ``nn.Linear`` does."""
        super().__init__(inputs, outputs, bias=False)


class VectorLeakyReLU(nn.Module):
    """Shortens what points against a learned direction."""

    def __init__(self, channels: int, slope: float = 0.2) -> None:
        """Choose.

        Args:
            channels: C.
            slope: what is left of the part against the direction.
        """
        super().__init__()
        self.directions = VectorLinear(channels, channels)
        self.slope = slope

    def forward(self, vectors: Tensor) -> Tensor:
        """(..., 3, C) -> (..., 3, C)."""
        direction = self.directions(vectors)
        length = (direction * direction).sum(-2, keepdim=True) + TINY
        along = (vectors * direction).sum(-2, keepdim=True)
        return vectors - (1.0 - self.slope) * along.clamp(max=0.0) / length * direction


class Invariants(nn.Module):
    """Inner products of every channel with three learned directions."""

    def __init__(self, channels: int) -> None:
        """``channels``: C."""
        super().__init__()
        self.frame = VectorLinear(channels, 3)

    def forward(self, vectors: Tensor) -> Tensor:
        """(..., 3, C) -> (..., 3 C)."""
        products = torch.einsum("...vc,...vf->...cf", vectors, self.frame(vectors))
        return products.flatten(-2)


def upward(like: Tensor) -> Tensor:
    """The constant channel along gravity, (..., 3, 1), for vectors (..., 3, C)."""
    up = like.new_zeros(3, 1)
    up[2] = 1.0
    return up.expand(*like.shape[:-2], 3, 1)
