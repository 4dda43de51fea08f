"""What learned models are told of a scene: points on its fixtures, described by the field."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import torch

from icd_agent.field.encoder import find_fixtures
from icd_agent.field.field import SceneField
from icd_agent.field.neighbours import gather, spread
from icd_envs.api import Float32Array, FloatArray

TOKENS: Final = 48
"""Points that describe a scene."""
SMALLEST: Final = 1e-3
"""[m] an object whose middle is closer than this to that of the scene is in no direction."""


class SceneTokens(NamedTuple):
    """E_s(P_s) of the paper: one feature per point, of one scene or of many (leading axes).

    Attributes:
        places: (..., A, 3) float32 [m] on surfaces of fixtures, spread out: world x and y, and
            the height above the floor.
        features: (..., A, D) float32 the field's descriptors there, in its length scale.
    """

    places: Float32Array
    features: Float32Array

    def seen_from(self, middle: FloatArray, size: float) -> Float32Array:
        """The tokens in a frame that turns and moves with scene and object.

        Its origin is on the floor under the middle of the tokens, its first axis points towards
        the object. So a network that reads them cannot know where in the world it is.

        Args:
            middle: (..., 3) [m] mean of the object's points.
            size: [m] unit of places.

        Returns:
            (..., A, 3 + D) float32.
        """
        origin = self.places.mean(axis=-2)[..., :2]
        toward = np.asarray(middle)[..., :2] - origin
        length = np.linalg.norm(toward, axis=-1, keepdims=True)
        along = np.where(length > SMALLEST, toward / np.maximum(length, SMALLEST), (1.0, 0.0))
        across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        about = self.places[..., :2] - origin[..., None, :]
        turned = [(about * axis[..., None, :]).sum(-1) for axis in (along, across)]
        placed = np.stack([*turned, self.places[..., 2]], axis=-1) / size
        return np.concatenate([placed, self.features], axis=-1).astype(np.float32)


def scene_tokens(field: SceneField, scene: FloatArray) -> SceneTokens:
    """Describe a scene.

    Args:
        field: in evaluation mode.
        scene: (M, 3) [m] scene cloud, world frame, of points that were seen.
    """
    cloud = torch.from_numpy(np.ascontiguousarray(scene, np.float32))[None]
    with torch.no_grad():
        floor, fixture = find_fixtures(cloud, field.config.floor_margin)
        places = gather(cloud, spread(cloud, TOKENS, fixture))
        features = field.query(field.encoder(cloud), places).descriptor
    places[..., 2] -= floor
    return SceneTokens(places[0].numpy(), (features[0] / field.config.length_scale).numpy())
