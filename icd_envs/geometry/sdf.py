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
        self._rotations = rotations
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
        excess = np.abs(self._local(points)) - self._half
        return np.asarray(_distance(excess).min(axis=0), dtype=np.float64)

    def gradient(self, points: FloatArray) -> Float64Array:
        """Direction in which the signed distance grows, that of the nearest or deepest box.

        Args:
            points: (M, 3) [m], world frame.

        Returns:
            (M, 3) unit vectors; any one of them where the distance has a kink.
        """
        local = self._local(points)
        box = _distance(np.abs(local) - self._half).argmin(axis=0)
        local = local[np.arange(len(points)), box]
        excess = np.abs(local) - self._half[box]
        away = np.maximum(excess, 0.0)
        inside = excess.max(axis=-1) <= 0.0
        away[inside] = excess[inside] == excess[inside].max(axis=-1, keepdims=True)
        direction = np.copysign(away, local)
        direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
        return np.einsum("mij,mj->mi", self._rotations[box], direction)

    def _local(self, points: FloatArray) -> FloatArray:
        """(M, B, 3) [m] points in the frame of every box."""
        local = (points @ self._to_local).reshape(len(points), len(self._half), 3)
        return np.asarray(local - self._local_centers)


def _distance(excess: FloatArray) -> FloatArray:
    """(M, B, 3) [m] coordinates beyond boxes' half extents -> (B, M) [m] signed distances."""
    # Axis by axis: NumPy takes four times as long to reduce an axis of three.
    x, y, z = np.ascontiguousarray(excess.T)
    inside = np.minimum(np.maximum(np.maximum(x, y), z), 0.0)
    x, y, z = (np.maximum(axis, 0.0) for axis in (x, y, z))
    return np.asarray(np.sqrt(x * x + y * y + z * z) + inside)
