"""The field itself: what a point in space is to the scene around it."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from icd_agent.field.config import FieldConfig
from icd_agent.field.encoder import SceneCode, SceneEncoder
from icd_agent.field.neighbours import gather, nearest
from icd_agent.field.vector_neurons import TINY, Invariants, VectorLeakyReLU, VectorLinear, upward
from icd_agent.field.whole import WholeScene

SHARPNESS = (1.0, 3.0)
"""Exponents of the distance weights of the nearest anchors: a smooth look and a close one."""
HEADS = len(SHARPNESS) + 1
"""Ways to weigh anchors; the last one is the outlook."""


class FieldOutput(NamedTuple):
    """What the field says about points x.

    Attributes:
        descriptor: (B, Q, D), the same for all yaws and places of scene and point together;
            distances between them are [m] at surfaces and fewer the farther away.
        occupancy: (B, Q) logit of being inside a fixture.
        gradient: (B, Q, 3) direction of the signed distance's gradient, world frame.
        log_distance: (B, Q) log(1 + |signed distance| / close_scale).
    """

    descriptor: Tensor
    occupancy: Tensor
    gradient: Tensor
    log_distance: Tensor


class SceneField(nn.Module):
    """f(x | P_s) of the paper: a descriptor of any point, given the scene's cloud."""

    def __init__(self, config: FieldConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.config = config
        channels, edge, width = config.channels, config.edge_width, config.width
        self.encoder = SceneEncoder(config)
        self.whole = WholeScene(config) if config.scope == "global" else None
        scalars = width
        if self.whole is None:
            self.edge = nn.Sequential(
                nn.Linear(2 * channels + 2, edge), nn.LeakyReLU(), nn.Linear(edge, edge)
            )
            gathered = HEADS * (channels + 1) + 1
            self.vectors = nn.Sequential(
                VectorLinear(gathered, channels), VectorLeakyReLU(channels)
            )
            self.invariants = Invariants(channels)
            scalars = HEADS * edge + 3 * channels + 1
        self.trunk = nn.Sequential(
            nn.Linear(scalars, width), nn.SiLU(), nn.Linear(width, width), nn.SiLU()
        )
        self.descriptor = nn.Linear(width, config.descriptor)
        self.heads = nn.Linear(width, 2)
        self.gates = nn.Linear(width, channels + 1)

    def forward(self, scene: Tensor, points: Tensor) -> FieldOutput:
        """Encode scenes and ask about points.

        Args:
            scene: (B, M, 3) [m] surface points, world frame.
            points: (B, Q, 3) [m], world frame.
        """
        return self.query(self.encoder(scene), points)

    def query(self, code: SceneCode, points: Tensor) -> FieldOutput:
        """Ask about points (B, Q, 3) [m] in encoded scenes."""
        height = points[..., 2:] - code.floor[:, None, None]
        if self.whole is None:
            scalars, vectors = self._look_around(code, points, height)
        else:
            scale = self.config.close_scale
            offsets = (points - code.anchors) / scale
            scalars, vectors = self.whole(code.features, offsets, height / scale)
        hidden = self.trunk(scalars)
        occupancy, log_distance = self.heads(hidden).unbind(-1)
        steered = torch.cat([vectors, upward(vectors)], dim=-1) * self.gates(hidden)[..., None, :]
        descriptor = self.config.length_scale * self.descriptor(hidden)
        return FieldOutput(descriptor, occupancy, steered.sum(-1), log_distance)

    def _look_around(
        self, code: SceneCode, points: Tensor, height: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Scalars (B, Q, S) and vectors (B, Q, 3, C) of the anchors around the points."""
        edges, weights, features = self._edges(code, points)
        told = self._gather_scalars(edges, features, weights)
        vectors = self._gather_vectors(edges, features, weights)
        vectors = self.vectors(torch.cat([vectors, upward(vectors)], dim=-1))
        scalars = [told, self.invariants(vectors), self._compress(height)]
        return torch.cat(scalars, dim=-1), vectors

    def _edges(self, code: SceneCode, points: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Offsets (B, Q, k, 3), weights (B, Q, k, HEADS), features (B, Q, k, 3, C)."""
        here = code.anchors.shape[1]
        squares, near = nearest(points, code.anchors, min(self.config.query_neighbours, here))
        far = torch.arange(min(self.config.outlook, here), device=points.device)
        far = far.expand(*near.shape[:2], -1)
        anchors = gather(code.anchors, torch.cat([near, far], dim=-1))
        offsets = points[:, :, None] - anchors
        weights = self._weights(squares, offsets[:, :, near.shape[-1] :].square().sum(-1))
        distance = (offsets.square().sum(-1, keepdim=True) + TINY).sqrt()
        edges = offsets * (self._compress(distance) / distance)
        return edges, weights, gather(code.features, torch.cat([near, far], dim=-1))

    def _weights(self, near: Tensor, far: Tensor) -> Tensor:
        """Squared distances (B, Q, k) and (B, Q, outlook) -> weights (B, Q, k + outlook, HEADS).

        Those of the nearest anchors add up to 1 at a surface and to less and less away from it:
        half-way between two fixtures, where all of them change at once, they hardly count.
        """
        scale = self.config.close_scale
        distance = (near + TINY).sqrt()
        # The last neighbour has no weight, so that nothing jumps when neighbours change.
        window = (1.0 - distance / (distance[..., -1:] + scale / 100)).clamp(min=0.0)
        soft = near + scale**2 / 16
        close = torch.stack([window * soft**-power for power in SHARPNESS], dim=-1)
        close = close / close.sum(dim=2, keepdim=True).clamp(min=torch.finfo(near.dtype).tiny)
        close = close * (scale / (scale + distance[..., :1, None])) ** 2
        away = (far.amin(dim=-1, keepdim=True) + TINY).sqrt()
        width = self.config.outlook_scale + self.config.outlook_growth * away
        wide = torch.softmax(-0.5 * far / width**2, dim=-1)
        return torch.cat(
            [functional.pad(close, (0, 1)), functional.pad(wide[..., None], (len(SHARPNESS), 0))],
            dim=2,
        )

    def _compress(self, metres: Tensor) -> Tensor:
        return torch.log1p(metres.clamp(min=0.0) / self.config.close_scale)

    def _gather_scalars(self, edges: Tensor, features: Tensor, weights: Tensor) -> Tensor:
        """What each neighbour says, (B, Q, HEADS * edge_width)."""
        along = (features * edges[..., None]).sum(-2)
        inputs = [along, features[..., 2, :], edges[..., 2:], edges.norm(dim=-1, keepdim=True)]
        said = self.edge(torch.cat(inputs, dim=-1))
        return torch.einsum("bqkh,bqkw->bqhw", weights, said).flatten(-2)

    def _gather_vectors(self, edges: Tensor, features: Tensor, weights: Tensor) -> Tensor:
        """(B, Q, 3, HEADS * (C + 1))."""
        both = torch.cat([features, edges[..., None]], dim=-1)
        return torch.einsum("bqkh,bqkvc->bqvhc", weights, both).flatten(-2)
