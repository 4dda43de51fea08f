"""The field of one static scene, evaluated once on grids and interpolated from then on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from torch.nn import functional

from icd_agent.field.encoder import SceneCode, find_fixtures
from icd_agent.field.field import FieldOutput, SceneField
from icd_agent.options import is_positive, require
from icd_envs.api import Float32Array, FloatArray

CHUNK = 8192
"""Points that the exact field is asked about at once."""
FARTHEST = 1e3
"""[m] coordinates are cut off there, far outside of every grid."""
GAP = 0.15
"""[m] fixtures farther apart than this get fine grids of their own."""


@dataclass(frozen=True)
class BakeConfig:
    """Where and how densely the field is evaluated.

    Attributes:
        fine: [m] spacing near fixtures.
        coarse: [m] spacing elsewhere.
        near: [m] distance from a fixture's points up to which it is fine.
        reach: [m] around the scene and the object that the coarse grid covers; what is farther
            out is taken as at its edge.
    """

    fine: float = 0.01
    coarse: float = 0.04
    near: float = 0.05
    reach: float = 0.3

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for field in ("fine", "coarse", "near", "reach"):
            require(is_positive(getattr(self, field)), field, getattr(self, field), "metres > 0")


class _Grid:
    """A lattice of points, and where its rows begin in the table."""

    def __init__(
        self, low: Float32Array, high: Float32Array, spacing: float, first_row: int
    ) -> None:
        self.low, self.spacing, self.first_row = low, spacing, first_row
        # At least one cell along every axis.
        self.cells = np.maximum(np.ceil((high - low) / spacing), 1).astype(np.int32)
        self.high = low + spacing * self.cells
        self.rows = int(np.prod(self.cells + 1))
        self._strides = np.array([self.cells[1] + 1, 1], np.int32) * (self.cells[2] + 1)

    def points(self) -> Float32Array:
        """(rows, 3) [m]."""
        axes = [
            a + self.spacing * np.arange(n + 1) for a, n in zip(self.low, self.cells, strict=True)
        ]
        mesh = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        return mesh.reshape(-1, 3).astype(np.float32)

    def holds(self, axes: list[Float32Array]) -> NDArray[np.int64]:
        """Indices of the points inside; coordinates (P,) [m] axis by axis."""
        inside = np.flatnonzero((axes[0] >= self.low[0]) & (axes[0] <= self.high[0]))
        for i in (1, 2):
            there = axes[i][inside]
            inside = inside[(there >= self.low[i]) & (there <= self.high[i])]
        return inside

    def corners(self, axes: list[Float32Array]) -> tuple[NDArray[np.int32], Float32Array]:
        """Rows (P, 8) and weights (P, 8) of the corners of the cells that points are in."""
        cells, shares = [], []
        for i in range(3):
            place = (axes[i] - self.low[i]) * np.float32(1.0 / self.spacing)
            np.clip(place, 0.0, self.cells[i] * np.float32(1.0 - 1e-6), out=place)
            cell = place.astype(np.int32)
            place -= cell
            cells.append(cell)
            shares.append((1.0 - place, place))
        row = cells[0] * self._strides[0] + cells[1] * self._strides[1] + cells[2]
        row += np.int32(self.first_row)
        rows = np.empty((len(row), 8), np.int32)
        weights = np.empty((len(row), 8), np.float32)
        for x in (0, 1):
            for y in (0, 1):
                pair = shares[0][x] * shares[1][y]
                for z in (0, 1):
                    corner = 4 * x + 2 * y + z
                    step = x * self._strides[0] + y * self._strides[1] + np.int32(z)
                    np.add(row, step, out=rows[:, corner])
                    np.multiply(pair, shares[2][z], out=weights[:, corner])
        return rows, weights


class BakedField:
    """Descriptors of any point by trilinear interpolation: fine near fixtures, coarse elsewhere.

    Attributes:
        evaluated: points that the network was asked about.
    """

    def __init__(
        self,
        field: SceneField,
        scene: Float32Array,
        object_points: FloatArray,
        config: BakeConfig | None = None,
    ) -> None:
        """Evaluate the field; takes seconds.

        Args:
            field: in evaluation mode.
            scene: (M, 3) [m] scene cloud.
            object_points: (N, 3) [m] where the object is and may go, for the coarse grid's size.
            config: spacing and reach.
        """
        config = config or BakeConfig()
        everything = np.concatenate([scene, np.asarray(object_points, np.float32).reshape(-1, 3)])
        low = everything.min(axis=0) - config.reach
        high = everything.max(axis=0) + config.reach
        cloud = torch.from_numpy(np.ascontiguousarray(scene, np.float32))[None]
        floor, stands = find_fixtures(cloud, field.config.floor_margin)
        low[2], fixture = floor.item(), scene[stands[0].numpy()]
        with torch.no_grad():
            code = field.encoder(cloud)
            self._grids = [_Grid(low, high, config.coarse, 0)]
            self._table = ask(field, code, self._grids[0].points()).descriptor[0]
            self.evaluated = len(self._table)
            grids, tables = self._grids, [self._table]
            for a, b in _fixture_boxes(fixture, low[2], config.near):
                last = grids[-1]
                grids = [*grids, _Grid(a, b, config.fine, last.first_row + last.rows)]
                points = grids[-1].points()
                near = np.isfinite(
                    cKDTree(fixture).query(points, distance_upper_bound=config.near)[0]
                )
                table = torch.from_numpy(self.features(points))  # the coarse grid's
                table[near] = ask(field, code, points[near]).descriptor[0]
                self.evaluated += int(np.count_nonzero(near))
                tables.append(table)
        self._grids, self._table = grids, torch.cat(tables)

    def features(self, points: FloatArray) -> Float32Array:
        """(..., 3) [m], world frame -> (..., D) descriptors."""
        # Diverged samples may hold anything.
        finite = np.nan_to_num(np.asarray(points, np.float32), nan=0.0)
        np.clip(finite, -FARTHEST, FARTHEST, out=finite)
        axes = [np.ascontiguousarray(finite[..., i]).ravel() for i in range(3)]
        which = np.zeros(len(axes[0]), np.uint8)
        for i, grid in enumerate(self._grids[1:], start=1):
            which[grid.holds(axes)] = i
        rows = np.empty((len(which), 8), np.int32)
        weights = np.empty((len(which), 8), np.float32)
        for i, grid in enumerate(self._grids):
            inside = np.flatnonzero(which == i)
            rows[inside], weights[inside] = grid.corners([axis[inside] for axis in axes])
        found = functional.embedding_bag(
            torch.from_numpy(rows),
            self._table,
            mode="sum",
            per_sample_weights=torch.from_numpy(weights),
        )
        return found.numpy().reshape(*points.shape[:-1], -1)


def ask(field: SceneField, code: SceneCode, points: FloatArray) -> FieldOutput:
    """What the network itself says of points (P, 3) [m] of one scene: (1, P, ...), in chunks.

    Args:
        field: in evaluation mode.
        code: of the scene.
        points: world frame.
    """
    chunks = torch.split(torch.from_numpy(np.ascontiguousarray(points, np.float32)), CHUNK)
    with torch.no_grad():
        parts = [field.query(code, chunk[None]) for chunk in chunks]
    return FieldOutput(*(torch.cat(part, dim=1) for part in zip(*parts, strict=True)))


def _fixture_boxes(
    fixture: Float32Array, floor: float, near: float
) -> list[tuple[Float32Array, Float32Array]]:
    """Axis-parallel boxes around the parts of the scene that stand apart from one another."""
    from scipy.cluster.hierarchy import fclusterdata

    if len(fixture) < 2:
        return []
    part = fclusterdata(fixture, GAP, criterion="distance", method="single")
    boxes = []
    for k in np.unique(part):
        a, b = fixture[part == k].min(axis=0) - near, fixture[part == k].max(axis=0) + near
        a[2] = max(a[2], floor)
        boxes.append((a, b))
    return boxes
