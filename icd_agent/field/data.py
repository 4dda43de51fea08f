"""Training scenes of the field, from recorded demonstrations."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from icd_agent.episodes import sound_episodes
from icd_agent.field.config import FieldConfig
from icd_agent.field.losses import Truth
from icd_agent.field.supervision import NEAR_SPREAD, Solid, draw_companions, draw_queries, supervise
from icd_envs.api import Float32Array
from icd_envs.demonstrations import Demonstrations
from icd_envs.geometry.sdf import BoxUnion

STATES = 12
"""States of an episode whose object points are asked about."""


class FieldScene(NamedTuple):
    """One scene.

    Attributes:
        cloud: (M, 3) float32 [m] scene cloud.
        object_points: (P, 3) float32 [m] places where the object has been.
        solid: the exact scene.
    """

    cloud: Float32Array
    object_points: Float32Array
    solid: Solid


class FieldData:
    """Scenes in memory, and random batches of queries in them."""

    def __init__(
        self,
        scenes: list[FieldScene],
        near_spread: float = NEAR_SPREAD,
        floor_margin: float = FieldConfig.floor_margin,
    ) -> None:
        """Keep them.

        Args:
            scenes: all with clouds of the same size.
            near_spread: [m] see ``draw_queries``.
            floor_margin: [m] that of the field which is trained, see ``FieldConfig``.
        """
        self._scenes = scenes
        self.near_spread = near_spread
        self._floor_margin = floor_margin

    def __len__(self) -> int:
        """Number of scenes."""
        return len(self._scenes)

    @classmethod
    def from_demonstrations(
        cls,
        demonstrations: Demonstrations,
        scenes: int,
        near_spread: float = NEAR_SPREAD,
        floor_margin: float = FieldConfig.floor_margin,
    ) -> FieldData:
        """The first so many episodes' scenes, drawn again from their seeds (12 ms each).

        Episodes whose physics diverged are left out: the object was anywhere in them.

        Raises:
            DemonstrationsError: all diverged.
        """
        found = []
        for i in sound_episodes(demonstrations, scenes):
            scene = demonstrations.scene(int(i))
            first, last = demonstrations.first_state[i : i + 2]
            states = np.unique(np.linspace(first, last - 1, STATES).astype(int))
            points = demonstrations.points(demonstrations.nodes[states]).reshape(-1, 3)
            found.append(FieldScene(scene.cloud, points, BoxUnion(scene.boxes)))
        return cls(found, near_spread, floor_margin)

    def draw(
        self, scenes: int, queries: int, rng: np.random.Generator, device: str = "cpu"
    ) -> tuple[Tensor, Truth, tuple[Tensor, Tensor]]:
        """A batch: clouds (B, M, 3), the truth about 2 Q points each, pairs of points.

        The second half of the points are companions of the first; each point is paired with its
        companion and with some other point of its scene.

        Args:
            scenes: B.
            queries: Q.
            rng: source of every draw.
            device: where the tensors go.
        """
        clouds, truths = [], []
        for i in rng.integers(len(self._scenes), size=scenes):
            scene = self._scenes[i]
            points = draw_queries(
                scene.cloud,
                scene.object_points,
                queries,
                rng,
                self.near_spread,
                self._floor_margin,
            )
            points = np.concatenate([points, draw_companions(points, rng)])
            clouds.append(scene.cloud)
            truths.append(supervise(points, scene.solid))
        companions, others = np.arange(queries), np.arange(2 * queries)
        first = np.concatenate([companions, others])
        second = np.concatenate([companions + queries, rng.permutation(others)])

        def tensor(array: NDArray[Any]) -> Tensor:
            return torch.from_numpy(array).to(device)

        truth = Truth(*(tensor(np.stack(arrays)) for arrays in zip(*truths, strict=True)))
        return tensor(np.stack(clouds)), truth, (tensor(first), tensor(second))
