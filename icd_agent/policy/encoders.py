"""What a policy makes of what it sees: one vector."""

from __future__ import annotations

from itertools import pairwise
from typing import Final, NamedTuple

import torch
from torch import Tensor, nn

from icd_agent.policy.config import PolicyConfig

KINDS: Final = 4
"""Points are of the object, the goal, the present scene or the goal's."""


class Seen(NamedTuple):
    """What a policy sees: metres, world frame, or normalised.

    Attributes:
        gripper: (B, O, 3) its place, oldest first.
        object: (B, O, K, 3).
        goal: (B, K, 3).
        scene: (B, A, 3 + F) places first.
        goal_scene: (B, A, 3 + F) of the scene that the goal was specified in.
    """

    gripper: Tensor
    object: Tensor
    goal: Tensor
    scene: Tensor
    goal_scene: Tensor


class KeyPointEncoder(nn.Module):
    """Key points as they are; of a scene's tokens, from a trained field, the largest features.

    The field's own features are the same wherever in the world a scene stands, so that pooled they
    could not tell where its fixtures are: each enters with its place.
    """

    def __init__(self, config: PolicyConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.scene = nn.Sequential(
            nn.Linear(3 + config.scene_features, 128),
            nn.ReLU(),
            nn.Linear(128, 128),
            nn.ReLU(),
            nn.Linear(128, config.encoded),
        )
        places = config.observed + (config.observed + 1) * config.object_points
        self.size = 3 * places + 2 * config.encoded

    def forward(self, seen: Seen) -> Tensor:
        """(B, ``size``)."""
        places = (seen.gripper, seen.object, seen.goal)
        scenes = (seen.scene, seen.goal_scene)
        parts = [part.flatten(1) for part in places]
        parts += [self.scene(part).amax(dim=1) for part in scenes]
        return torch.cat(parts, dim=-1)


class PointEncoder(nn.Module):
    """The point cloud encoder of 3D Diffusion Policy (Ze et al., RSS 2024), beside the gripper's.

    All points go through the same layers, each with what it is a point of.
    """

    def __init__(self, config: PolicyConfig) -> None:
        """Build the layers."""
        super().__init__()
        widths = 3 + KINDS, 64, 128, 256
        layers: list[nn.Module] = []
        for before, after in pairwise(widths):
            layers += [nn.Linear(before, after), nn.LayerNorm(after), nn.ReLU()]
        self.point = nn.Sequential(*layers)
        self.project = nn.Sequential(
            nn.Linear(widths[-1], config.encoded), nn.LayerNorm(config.encoded)
        )
        self.gripper = nn.Sequential(nn.Linear(3, 64), nn.ReLU(), nn.Linear(64, config.encoded))
        self.size = 2 * config.encoded * config.observed

    def forward(self, seen: Seen) -> Tensor:
        """(B, ``size``)."""
        still = torch.stack(
            [
                self._pooled(seen.goal, 1),
                self._pooled(seen.scene, 2),
                self._pooled(seen.goal_scene, 3),
            ]
        ).amax(dim=0)
        # Largest of all points, with those that do not move looked at only once.
        pooled = torch.maximum(self._pooled(seen.object, 0), still[:, None])
        parts = [self.project(pooled), self.gripper(seen.gripper)]
        return torch.cat(parts, dim=-1).flatten(1)

    def _pooled(self, points: Tensor, kind: int) -> Tensor:
        """(..., N, 3) -> (..., W)."""
        which = points.new_zeros(KINDS)
        which[kind] = 1.0
        found: Tensor = self.point(torch.cat([points, which.expand(*points.shape[:-1], -1)], -1))
        return found.max(dim=-2).values
