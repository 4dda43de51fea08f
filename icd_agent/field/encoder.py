"""The scene encoder: anchors on the fixtures' surfaces, each with features of its surroundings."""

from __future__ import annotations

from typing import Final, NamedTuple

import torch
from torch import Tensor, nn

from icd_agent.field.config import FieldConfig
from icd_agent.field.neighbours import gather, nearest, spread
from icd_agent.field.vector_neurons import VectorLeakyReLU, VectorLinear, upward
from icd_agent.field.whole import Summary

FLAT: Final = 1e-4
"""[m] by which points of one height may differ."""
NOISE: Final = 0.02
"""[m] within which noise may spread the lowest tenth of a scene's points."""


class SceneCode(NamedTuple):
    """An encoded scene; it turns and moves with the scene about and along gravity's axis.

    Attributes:
        anchors: (B, A, 3) [m] on surfaces of fixtures, world frame, each far from all before it;
            with the global scope only one, in their middle.
        features: (B, A, 3, C) vectors, in units of the close scale or of none.
        floor: (B,) [m] height of the floor.
    """

    anchors: Tensor
    features: Tensor
    floor: Tensor


class SceneEncoder(nn.Module):
    """Encodes what the scene looks like around each of its anchors; no absolute place enters."""

    def __init__(self, config: FieldConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.config = config
        channels = config.channels
        self.surface = nn.Sequential(
            VectorLinear(4, channels),
            VectorLeakyReLU(channels),
            VectorLinear(channels, channels),
            VectorLeakyReLU(channels),
        )
        self.exchange = nn.ModuleList(_Exchange(channels) for _ in range(config.graph_layers))
        self.summary = Summary(channels, config.code_channels) if config.scope == "global" else None

    def forward(self, scene: Tensor) -> SceneCode:
        """Encode scenes.

        Args:
            scene: (B, M, 3) [m] surface points, world frame.

        Returns:
            The code, for ``SceneField.query``.
        """
        floor, fixture = find_fixtures(scene, self.config.floor_margin)
        chosen = spread(scene, self.config.anchors, fixture)
        anchors = gather(scene, chosen)
        features = self._look_around(scene, fixture, anchors)
        _, around = nearest(anchors, anchors, min(self.config.graph_neighbours, len(anchors[0])))
        offsets = self._scaled(gather(anchors, around) - anchors[:, :, None])
        for layer in self.exchange:
            features = layer(features, gather(features, around), offsets)
        if self.summary is not None:
            middle = anchors.mean(dim=1, keepdim=True)
            features = self.summary(features, self._scaled(anchors - middle))
            anchors = middle
        return SceneCode(anchors, features, floor)

    def _look_around(self, scene: Tensor, fixture: Tensor, anchors: Tensor) -> Tensor:
        count = min(self.config.anchor_neighbours, scene.shape[1])
        squares, around = nearest(anchors, scene, count, fixture)
        offsets = self._scaled(gather(scene, around) - anchors[:, :, None])
        # Points that are not there (fewer fixtures than k) repeat the anchor itself.
        offsets = offsets.masked_fill((squares > 1e5)[..., None, None], 0.0)
        middle = offsets.mean(dim=2, keepdim=True).expand_as(offsets)
        turn = torch.linalg.cross(offsets, middle, dim=-2)
        edges = torch.cat([offsets, middle, turn, upward(offsets)], dim=-1)
        features: Tensor = self.surface(edges).mean(dim=2)
        return features

    def _scaled(self, offsets: Tensor) -> Tensor:
        """(..., 3) [m] -> (..., 3, 1) in units of the close scale."""
        return offsets[..., None] / self.config.close_scale


def find_fixtures(scene: Tensor, margin: float) -> tuple[Tensor, Tensor]:
    """Tell floor from what stands on it, also where a camera's noise has roughened both.

    Where the lowest points are all at one height, that is the floor. Where they are not, but the
    lowest tenth lies within what noise may do, the floor is where that tenth ends.

    Args:
        scene: (B, M, 3) [m] surface points, world frame.
        margin: [m] points this close above the floor are of it; where noise reaches farther, points
            that it may have raised.

    Returns:
        (B,) [m] height of the floor; (B, M) bool, points of fixtures, or all in a
        scene of bare floor, which has nothing else to hold on to.
    """
    height = scene[..., 2]
    lowest, low, tenth = (
        torch.quantile(height, share, dim=1, interpolation="lower") for share in (0.0, 0.016, 0.1)
    )
    rough = (low - lowest > FLAT) & (tenth - lowest < NOISE)
    floor = torch.where(rough, tenth, lowest)
    above = torch.where(rough, 4.0 * (tenth - low), 0.0).clamp(min=margin)
    fixture = height > (floor + above)[:, None]
    return floor, fixture | ~fixture.any(dim=1, keepdim=True)


class _Exchange(nn.Module):
    """One round of messages between neighbouring anchors, added to what is known."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.there = VectorLinear(channels, channels)
        self.here = VectorLinear(channels + 1, channels)
        self.offset = VectorLinear(1, channels)
        self.activation = VectorLeakyReLU(channels)
        self.out = VectorLinear(channels, channels)

    def forward(self, features: Tensor, around: Tensor, offsets: Tensor) -> Tensor:
        """(B, A, 3, C), those of k neighbours (B, A, k, 3, C), offsets (B, A, k, 3, 1)."""
        here = self.here(torch.cat([features, upward(features)], dim=-1))[:, :, None]
        messages = self.activation(here + self.there(around) + self.offset(offsets))
        updated: Tensor = features + self.out(messages.mean(dim=2))
        return updated
