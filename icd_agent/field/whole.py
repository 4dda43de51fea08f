"""One code for a whole scene, and what it says about a point: the paper's baseline Global NDF.

The first NDF (Simeonov et al., 2022) averages what is known of all points, in rounds in which every
point is told the average, and multiplies a query with the vectors of the last one. Here sines of
these products and distances to the vectors' ends are told beside them.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from icd_agent.field.config import FieldConfig
from icd_agent.field.vector_neurons import TINY, Invariants, VectorLeakyReLU, VectorLinear, upward


class Summary(nn.Module):
    """One code for all anchors, from what they know and where they are.

    Averages alone cannot tell two clips apart: seen from the middle between them, whatever points
    to one cancels what points to the other. So every anchor is told the average and asked again.
    """

    def __init__(self, channels: int, code_channels: int, rounds: int = 3) -> None:
        """Choose.

        Args:
            channels: vector channels of an anchor.
            code_channels: of the code.
            rounds: times that anchors are told what all of them said.
        """
        super().__init__()
        half = code_channels // 2
        self.begin = VectorLinear(channels + 2, half)
        self.rounds = nn.ModuleList(_Round(half) for _ in range(rounds))
        self.weights = nn.Sequential(
            nn.Linear(3 * half, half), nn.SiLU(), nn.Linear(half, code_channels)
        )
        self.frame = VectorLinear(half, 3)
        self.out = VectorLinear(2 * half, code_channels)

    def forward(self, features: Tensor, places: Tensor) -> Tensor:
        """(B, A, 3, C) and places about their middle (B, A, 3, 1) -> (B, 1, 3, code_channels)."""
        told = self.begin(torch.cat([features, places, upward(features)], dim=-1))
        for ask in self.rounds:
            told = ask(told)
        common = told.mean(dim=1, keepdim=True)
        seen = torch.einsum("bavc,bovf->bacf", told, self.frame(common)).flatten(-2)
        weights = self.weights(seen).softmax(dim=1)
        values = self.out(torch.cat([told, common.expand_as(told)], dim=-1))
        return torch.einsum("bac,bavc->bvc", weights, values)[:, None]


class _Round(nn.Module):
    """Anchors, each told the average of all, added to what it knew."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            VectorLinear(2 * channels + 1, channels),
            VectorLeakyReLU(channels),
            VectorLinear(channels, channels),
            VectorLeakyReLU(channels),
            VectorLinear(channels, channels),
        )

    def forward(self, told: Tensor) -> Tensor:
        """(B, A, 3, C) -> the same."""
        common = told.mean(dim=1, keepdim=True).expand_as(told)
        updated: Tensor = told + self.layers(torch.cat([told, common, upward(told)], dim=-1))
        return updated


class WholeScene(nn.Module):
    """What the code says about a point."""

    def __init__(self, config: FieldConfig) -> None:
        """Build the layers."""
        super().__init__()
        channels, width = config.code_channels, config.width
        self.invariants = Invariants(channels)
        self.code = nn.Linear(4 * channels, width)
        self.place = nn.Linear(4 * channels + 3, width)
        self.blocks = nn.ModuleList(_Block(width) for _ in range(config.code_blocks))
        self.vectors = nn.Sequential(
            VectorLinear(channels + 2, config.channels), VectorLeakyReLU(config.channels)
        )

    def forward(self, code: Tensor, offsets: Tensor, height: Tensor) -> tuple[Tensor, Tensor]:
        """Ask about points.

        Args:
            code: (B, 1, 3, code_channels).
            offsets: (B, Q, 3) from the scene's middle, in close scales.
            height: (B, Q, 1) above the floor, in close scales.

        Returns:
            Scalars (B, Q, width) and vectors (B, Q, 3, channels).
        """
        along = torch.einsum("bqv,bvc->bqc", offsets, code[:, 0])
        radius = (offsets.square().sum(-1, keepdim=True) + TINY).sqrt()
        squares = radius.square() - 2.0 * along + code[:, 0].square().sum(-2)[:, None]
        apart = torch.log1p((squares.clamp(min=0.0) + TINY).sqrt())
        inputs = [along, along.sin(), along.cos(), apart, height, torch.log1p(height.abs()), radius]
        known = torch.cat([self.invariants(code), code[..., 2, :]], dim=-1)
        about = self.code(known)
        hidden = self.place(torch.cat(inputs, dim=-1)) + about
        for block in self.blocks:
            hidden = block(hidden, about)
        everywhere = code.expand(-1, offsets.shape[1], -1, -1)
        told = torch.cat([everywhere, offsets[..., None], upward(everywhere)], dim=-1)
        return hidden, self.vectors(told)


class _Block(nn.Module):
    """A residual layer that is told the code once more."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = nn.Linear(width, width)
        self.scale = nn.Linear(width, width)
        self.second = nn.Linear(width, width)

    def forward(self, hidden: Tensor, about: Tensor) -> Tensor:
        """(B, Q, width) and (B, 1, width) -> (B, Q, width)."""
        inner = self.first(nn.functional.silu(hidden)) * (1.0 + self.scale(about))
        updated: Tensor = hidden + self.second(nn.functional.silu(inner))
        return updated
