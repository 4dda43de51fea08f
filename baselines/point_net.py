"""Point clouds for Stable-Baselines3: a PointNet as features extractor (Qi et al., CVPR 2017).

Needs the extra ``[rl]``; see docs/reinforcement-learning.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import Tensor, nn

from icd_envs.errors import InvalidOptionError

MASK: Final = "_mask"
"""What follows a cloud's name in the name of its mask."""


class PointNetExtractor(BaseFeaturesExtractor):
    """One vector from an observation of point clouds and vectors.

    All clouds go through the same PointNet, each gives ``widths[-1]`` numbers that do not depend on
    the order of its points; vectors are handed through. A point whose mask is 0 has no influence, a
    cloud without a visible point gives zeros.

    Attributes:
        clouds: names of the parts that are clouds, in the order of their features.
        vectors: names of the parts that are handed through, after the clouds.
    """

    def __init__(
        self,
        observation_space: spaces.Dict,
        points: int = 128,
        widths: Sequence[int] = (64, 128, 256),
    ) -> None:
        """Look at the space; Stable-Baselines3 passes the rest on from ``policy_kwargs``.

        Args:
            observation_space: parts (N, 3) are clouds, (N,) called as a cloud and ``_mask`` its
                mask, other (D,) vectors.
            points: of a larger cloud this many are used, evenly spaced, both ends included.
            widths: of the layers that every point goes through.

        Raises:
            InvalidOptionError: if there is no cloud, a part is neither, or on numbers below 1.
        """
        if points < 1 or not widths or min(widths) < 1:
            raise InvalidOptionError(
                f"points and widths must be at least 1, got points={points}, widths={widths}"
            )
        shapes = {name: part.shape or () for name, part in observation_space.items()}
        clouds = [name for name, shape in shapes.items() if shape[1:] == (3,)]
        masked = [name for name in clouds if name + MASK in shapes]
        parts = {*clouds, *(name + MASK for name in masked)}
        vectors = [name for name in shapes if name not in parts]
        if not clouds or any(len(shapes[name]) != 1 for name in vectors):
            raise InvalidOptionError(
                f"observation has parts {shapes}: PointNetExtractor needs clouds (N, 3), their "
                "masks (N,) and vectors (D,): give it the environment's dictionary"
            )
        features = len(clouds) * widths[-1] + sum(shapes[name][0] for name in vectors)
        super().__init__(observation_space, features_dim=features)
        self.clouds, self.vectors, self._masked = clouds, vectors, masked
        self._kept = {name: _spread(shapes[name][0], points) for name in clouds}
        layers = [
            layer
            for before, after in zip((3, *widths), widths, strict=False)
            for layer in (nn.Linear(before, after), nn.ReLU())
        ]
        self._point_net = nn.Sequential(*layers)

    def forward(self, observations: dict[str, Tensor]) -> Tensor:
        """(B, ...) parts of the observation by name -> (B, features_dim)."""
        features = [self._cloud_features(name, observations) for name in self.clouds]
        return torch.cat([*features, *(observations[name] for name in self.vectors)], dim=1)

    def _cloud_features(self, name: str, observations: dict[str, Tensor]) -> Tensor:
        kept = self._kept[name]
        features: Tensor = self._point_net(observations[name][:, kept])
        if name in self._masked:
            hidden = observations[name + MASK][:, kept] < 0.5
            # After a ReLU nothing is below 0: a hidden point is never the largest.
            features = features.masked_fill(hidden[..., None], 0.0)
        return features.amax(dim=1)


def _spread(there: int, wanted: int) -> list[int]:
    """Indices of at most ``wanted`` of ``there`` points, evenly spaced."""
    spread = np.linspace(0, there - 1, min(there, wanted)).round()
    return [int(index) for index in spread]
