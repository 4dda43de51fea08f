"""Clouds on the surfaces of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from icd_envs.api import Float32Array, Float64Array
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box

FLOOR_MARGIN: Final = 0.2
"""[m] floor points lie in the fixtures' bounding rectangle, grown by this."""
SURFACE: Final = 1e-6
"""[m] a sampled point deeper than this lies inside another box and is not visible."""
LOWEST: Final = 1e-4
"""[m] undersides standing on the floor, and the floor below them, are not visible."""


def sample_scene(
    boxes: Sequence[Box], count: int, floor: int, rng: np.random.Generator
) -> Float32Array:
    """Cloud of the exposed surfaces of boxes, by area, and of the floor around them.

    The floor gets few points: a dense one would crowd the fixtures out of any
    nearest-neighbour query.

    Args:
        boxes: the fixtures.
        count: points in all.
        floor: how many of them lie on the floor.
        rng: source of every draw.

    Returns:
        (count, 3) [m], world frame, fixtures first.
    """
    union = BoxUnion(boxes)
    surface = _exposed(boxes, union, count - floor, rng)
    low = surface[:, :2].min(axis=0) - FLOOR_MARGIN
    high = surface[:, :2].max(axis=0) + FLOOR_MARGIN
    ground = np.empty((0, 3))
    while len(ground) < floor:
        points = np.column_stack([rng.uniform(low, high, (floor, 2)), np.zeros(floor)])
        ground = np.concatenate([ground, points[union(points) > LOWEST]])
    return np.concatenate([surface, ground[:floor]]).astype(np.float32)


def _exposed(
    boxes: Sequence[Box], union: BoxUnion, count: int, rng: np.random.Generator
) -> Float64Array:
    import trimesh

    mesh = trimesh.util.concatenate(
        [trimesh.creation.box(2 * box.half, transform=_pose(box)) for box in boxes]
    )
    found = np.empty((0, 3))
    while len(found) < count:
        points, _ = trimesh.sample.sample_surface(mesh, 2 * count, seed=rng)
        points = np.asarray(points)
        visible = (union(points) > -SURFACE) & (points[:, 2] > LOWEST)
        found = np.concatenate([found, points[visible]])
    return found[:count]


def _pose(box: Box) -> Float64Array:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = box.rotation, box.center
    return pose
