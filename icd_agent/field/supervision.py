"""What the field is taught: inside or outside, and where the surface is."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import torch

from icd_agent.field.config import FieldConfig
from icd_agent.field.encoder import find_fixtures
from icd_envs.api import Float32Array, FloatArray

NEAR = 0.5
"""Share of the queries near surfaces."""
ON_OBJECT = 0.25
"""Share at places where the object has been; the rest is spread over the scene's surroundings."""
NEAR_SPREAD = 0.015
"""[m] standard deviation of the distance to the surface, of half of them at least."""
OBJECT_SPREAD = 0.01
"""[m] of noise on the object's places."""
SURROUNDINGS = 0.25
"""[m] around the scene's cloud that queries are spread over."""
BESIDE = 0.08
"""[m] largest distance between a query and its companion."""


class Solid(Protocol):
    """What stands in a scene; ``BoxUnion`` and ``MeshSolid`` are."""

    def __call__(self, points: FloatArray) -> FloatArray:
        """Signed distance (M,) [m] of points (M, 3) [m], negative inside."""
        ...

    def gradient(self, points: FloatArray) -> FloatArray:
        """(M, 3) unit vectors in which the signed distance of points (M, 3) [m] grows."""
        ...


class Targets(NamedTuple):
    """Points of one scene and the truth about them.

    Attributes:
        points: (Q, 3) float32 [m], world frame.
        distance: (Q,) float32 [m] signed distance, negative inside.
        gradient: (Q, 3) float32 unit vectors.
    """

    points: Float32Array
    distance: Float32Array
    gradient: Float32Array


def above_floor(scene: FloatArray, margin: float = FieldConfig.floor_margin) -> FloatArray:
    """Points of fixtures; of a scene of bare floor, which has nothing else to show, all points.

    Args:
        scene: (M, 3) [m] scene cloud.
        margin: [m] see ``find_fixtures``.

    Returns:
        (F, 3) [m].
    """
    _, fixture = find_fixtures(torch.from_numpy(np.ascontiguousarray(scene))[None], margin)
    return scene[fixture[0].numpy()]


def draw_queries(
    scene: FloatArray,
    object_points: FloatArray,
    count: int,
    rng: np.random.Generator,
    near_spread: float = NEAR_SPREAD,
    floor_margin: float = FieldConfig.floor_margin,
) -> Float32Array:
    """Points to ask about: near surfaces, where the object has been, and anywhere around.

    Args:
        scene: (M, 3) [m] scene cloud.
        object_points: (P, 3) [m] places of the object in this scene.
        count: Q.
        rng: source of every draw.
        near_spread: [m] the other half's; for thick fixtures, whose insides would hardly be
            asked about otherwise.
        floor_margin: [m] see ``above_floor``.

    Returns:
        (Q, 3) float32 [m].
    """
    near, there = int(NEAR * count), int(ON_OBJECT * count)
    fixture = above_floor(scene, floor_margin)
    low, high = scene.min(axis=0) - SURROUNDINGS, scene.max(axis=0) + SURROUNDINGS
    low[2] = scene[:, 2].min()
    spread = np.where(np.arange(near) < near // 2, NEAR_SPREAD, near_spread)[:, None]
    parts = [
        rng.choice(fixture, near) + rng.normal(0.0, spread, (near, 3)),
        rng.choice(object_points, there) + rng.normal(0.0, OBJECT_SPREAD, (there, 3)),
        rng.uniform(low, high, (count - near - there, 3)),
    ]
    return np.concatenate(parts).astype(np.float32)


def draw_companions(points: FloatArray, rng: np.random.Generator) -> Float32Array:
    """A point near each of the points (Q, 3) [m], at most ``BESIDE`` away: (Q, 3) float32 [m]."""
    offset = rng.normal(size=points.shape)
    offset *= rng.uniform(0.0, BESIDE, (len(points), 1)) / np.linalg.norm(
        offset, axis=1, keepdims=True
    )
    return (points + offset).astype(np.float32)


def supervise(points: Float32Array, solid: Solid) -> Targets:
    """The truth about points (Q, 3) [m], from the exact solids of the scene."""
    return Targets(
        points,
        solid(points.astype(np.float64)).astype(np.float32),
        solid.gradient(points.astype(np.float64)).astype(np.float32),
    )
