"""What learned models are told of a scene: descriptors of places on fixtures and around them."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import torch
from torch import Tensor

from icd_agent.field.encoder import find_fixtures
from icd_agent.field.field import SceneField
from icd_agent.field.neighbours import gather, spread
from icd_envs.api import Float32Array, Float64Array, FloatArray

SURFACE: Final = 48
"""Tokens on surfaces of fixtures; they come first."""
REACH: Final = 0.6
"""[m] the others are on a lattice that reaches so far from the middle of those, both ways."""
SIDE: Final = 5
"""Places along a side of the lattice."""
HEIGHTS: Final = (0.02, 0.15, 0.35)
"""[m] of its layers above the floor."""
TOKENS: Final = SURFACE + SIDE**2 * len(HEIGHTS)
"""Points that describe a scene."""
SMALLEST: Final = 1e-3
"""[m] an object whose middle is closer than this to that of the scene is in no direction."""


class Frame(NamedTuple):
    """A frame that turns and moves with scene and object; heights stay as they are.

    Attributes:
        origin: (..., 2) [m].
        along: (..., 2) first axis.
    """

    origin: FloatArray
    along: FloatArray

    def place(self, points: FloatArray) -> Float64Array:
        """World (..., N, 3) [m] -> this frame."""
        x, y = self._axes()
        about = points[..., :2] - self.origin[..., None, :]
        return np.stack([(about * x).sum(-1), (about * y).sum(-1), points[..., 2]], axis=-1)

    def back(self, points: FloatArray) -> Float64Array:
        """This frame (..., N, 3) [m] -> world."""
        x, y = self._axes()
        flat = self.origin[..., None, :] + points[..., :1] * x + points[..., 1:2] * y
        return np.concatenate([flat, points[..., 2:]], axis=-1)

    def _axes(self) -> tuple[FloatArray, FloatArray]:
        across = np.stack([-self.along[..., 1], self.along[..., 0]], axis=-1)
        return self.along[..., None, :], across[..., None, :]


class SceneTokens(NamedTuple):
    """Where the paper has E_s(P_s): one feature per point, of one scene or of many (leading axes).

    Not features of the field's encoder, as there, but the descriptors that the field has at these
    places.

    Attributes:
        places: (..., A, 3) float32 [m] on surfaces of fixtures, spread out, then on a lattice
            around them: world x and y, and the height above the floor.
        features: (..., A, D) float32 the field's descriptors there, in its length scale.
    """

    places: Float32Array
    features: Float32Array

    def frame(self, middle: FloatArray) -> Frame:
        """Its origin is the middle of the fixtures' tokens, its first axis points to the object.

        Args:
            middle: (..., 3) [m] mean of the object's points.
        """
        origin = self.places[..., :SURFACE, :2].mean(axis=-2)
        toward = np.asarray(middle)[..., :2] - origin
        length = np.linalg.norm(toward, axis=-1, keepdims=True)
        along = np.where(length > SMALLEST, toward / np.maximum(length, SMALLEST), (1.0, 0.0))
        return Frame(origin, along)

    def seen_from(self, middle: FloatArray, size: float) -> Float32Array:
        """The tokens in that frame: a network cannot know where in the world it is.

        Args:
            middle: (..., 3) [m] mean of the object's points.
            size: [m] unit of places.

        Returns:
            (..., A, 3 + D) float32.
        """
        placed = self.frame(middle).place(self.places) / size
        return np.concatenate([placed, self.features], axis=-1).astype(np.float32)


def scene_tokens(field: SceneField, scene: FloatArray) -> SceneTokens:
    """Describe a scene.

    The lattice tells what the field is away from surfaces, where most of the object is most of the
    time: from surfaces alone, a network would have to learn the field itself.

    Args:
        field: in evaluation mode.
        scene: (M, 3) [m] scene cloud, world frame, of points that were seen.
    """
    cloud = torch.from_numpy(np.ascontiguousarray(scene, np.float32))[None]
    with torch.no_grad():
        floor, fixture = find_fixtures(cloud, field.config.floor_margin)
        places = gather(cloud, spread(cloud, SURFACE, fixture))
        places = torch.cat([places, _lattice(places[0], float(floor))[None]], dim=1)
        features = field.query(field.encoder(cloud), places).descriptor
    places[..., 2] -= floor
    return SceneTokens(places[0].numpy(), (features[0] / field.config.length_scale).numpy())


def _lattice(places: Tensor, floor: float) -> Tensor:
    """(SIDE^2 x layers, 3) [m] around places (A, 3); turned so that the farthest is ahead."""
    origin = places[:, :2].mean(dim=0)
    away = places[:, :2] - origin
    far = away[away.norm(dim=1).argmax()]
    along = far / far.norm().clamp(min=SMALLEST)
    across = torch.stack([-along[1], along[0]])
    steps = torch.linspace(-REACH, REACH, SIDE)
    x, y, z = torch.meshgrid(steps, steps, torch.tensor(HEIGHTS), indexing="ij")
    flat = origin + x[..., None] * along + y[..., None] * across
    return torch.cat([flat, floor + z[..., None]], dim=-1).flatten(0, 2)
