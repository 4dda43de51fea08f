"""Is a notebook folded, and does it lie on a table? Pure functions on its cloud.

The cloud is a grid in material order: ``COLUMNS`` columns from the held edge to the free one, each
of ``ROWS`` points from left to right. Folding about the spine brings column c onto column
``COLUMNS - 1 - c``.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from icd_envs.api import BoolArray, FloatArray

COLUMNS: Final = 20
ROWS: Final = 10

FOLDED: Final = 0.03
"""[m] mean gap between the covers of a folded notebook: 0.015 when closed, 0.03 at 15 degrees."""
SUNK: Final = 0.002
"""[m] by which the lowest point may lie under the table's top: contacts give way a little."""
LYING: Final = 0.06
"""[m] over the table's top, below which every point is when a folded notebook lies on it."""


def fold_gap(points: FloatArray) -> FloatArray:
    """Mean distance [m] between the points that folding brings together.

    Args:
        points: (..., N, 3) [m] clouds in material order.

    Returns:
        (...) [m].
    """
    grid = points.reshape(*points.shape[:-2], COLUMNS, ROWS, 3)
    half = COLUMNS // 2
    gap = grid[..., :half, :, :] - grid[..., : half - 1 : -1, :, :]
    return np.asarray(np.linalg.norm(gap, axis=-1).mean(axis=(-2, -1)))


def cover_gap(points: FloatArray) -> FloatArray:
    """Distance [m] between the middles of the two covers, never more than ``fold_gap``.

    Args:
        points: (..., n, 3) [m] clouds in material order, or any even selection of their points.

    Returns:
        (...) [m].
    """
    half = points.shape[-2] // 2
    gap = points[..., :half, :].mean(axis=-2) - points[..., -half:, :].mean(axis=-2)
    return np.asarray(np.linalg.norm(gap, axis=-1))


def on_top(points: FloatArray, table: FloatArray) -> BoolArray:
    """Whether every point is within a table's footprint and close above its top.

    Args:
        points: (..., N, 3) [m] clouds, world frame.
        table: (..., 6) position x, y [m], yaw [rad], half extents x, y [m], height [m].

    Returns:
        (...) booleans.
    """
    x, y, yaw, half_x, half_y, top = np.moveaxis(table[..., None, :], -1, 0)
    x, y, height = points[..., 0] - x, points[..., 1] - y, points[..., 2] - top
    inside = np.abs(np.cos(yaw) * x + np.sin(yaw) * y) <= half_x
    inside &= np.abs(np.cos(yaw) * y - np.sin(yaw) * x) <= half_y
    return np.asarray(np.all(inside & (height >= -SUNK) & (height <= LYING), axis=-1))
