"""Exact signed distance to unions of oriented boxes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from icd_envs.api import Float64Array, FloatArray
from icd_envs.scenes.boxes import Box


class BoxUnion:
    """Signed distance to the union of boxes, vectorised over points.

    Outside the union the distance is exact; inside overlapping boxes it is a bound (the deepest
    box counts), with the right sign everywhere.
    """

    def __init__(self, boxes: Sequence[Box]) -> None:
        """Stack the boxes.

        Args:
            boxes: at least one.
        """
        self._centers = np.stack([box.center for box in boxes])
        self._half = np.stack([box.half for box in boxes])
        rotations = np.stack([box.rotation for box in boxes])
        # One (3, 3B) matrix takes a world vector into all box frames at once.
        self._to_local = np.concatenate(list(rotations), axis=1)
        self._local_centers = np.einsum("bji,bj->bi", rotations, self._centers)

    def __call__(self, points: FloatArray) -> Float64Array:
        """Signed distance, negative inside.

        Args:
            points: (M, 3) [m], world frame.

        Returns:
            (M,) [m].
        """
        local = (points @ self._to_local).reshape(len(points), len(self._half), 3)
        excess = np.abs(local - self._local_centers) - self._half
        outside = np.linalg.norm(np.maximum(excess, 0.0), axis=-1)
        inside = np.minimum(excess.max(axis=-1), 0.0)
        return np.asarray((outside + inside).min(axis=-1), dtype=np.float64)
