"""Which points a camera sees, by ray casting: no OpenGL."""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np

from icd_envs.api import BoolArray, FloatArray
from icd_envs.scenes import layers
from icd_envs.scenes.layers import VISIBLE_GROUPS

ASPECT: Final = 4 / 3
"""Width to height of the picture."""
SURFACE: Final = 0.002
"""[m] a hit this near before a point is the surface that the point lies on."""
SKIN: Final = 0.02
"""[m] a point inside the object is seen through this much of the object: its material points lie
on a centre line, which a ray reaches through the radius of 3 to 8 mm, or more at a slant."""


class PointCamera:
    """A fixed camera of a scene that tells which points are in its picture and not hidden."""

    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        """Choose a camera.

        Args:
            model: the scene.
            name: a camera that stands still in the world.
        """
        self._model = model
        camera = model.camera(name).id
        self._position = model.cam_pos[camera].copy()
        self._axes = model.cam_mat0[camera].reshape(3, 3).copy()
        self._half_height = float(np.tan(np.deg2rad(model.cam_fovy[camera]) / 2))
        self._own = model.geom_group == layers.CABLE["group"]

    def sees(self, data: mujoco.MjData, points: FloatArray) -> BoolArray:
        """Whether each point is in the picture with nothing but its own surface before it.

        Args:
            data: state; its positions must be up to date.
            points: (N, 3) [m], world frame: on surfaces, or inside the object.

        Returns:
            (N,) booleans; False where a point is not finite.
        """
        offset = np.asarray(points, dtype=np.float64) - self._position
        # The camera's own place is never in the picture.
        offset = np.where(np.isfinite(offset).all(axis=1, keepdims=True), offset, 0.0)
        seen = self._in_picture(offset)
        offset = offset[seen]
        distance = np.linalg.norm(offset, axis=1)
        hit = np.full(len(offset), -1, dtype=np.int32)
        reach = np.full(len(offset), -1.0)
        mujoco.mj_multiRay(
            self._model, data, self._position, (offset / distance[:, None]).ravel(),
            VISIBLE_GROUPS, True, -1, hit, reach, None, len(offset), mujoco.mjMAXVAL,
        )  # fmt: skip
        before = np.where(hit < 0, 0.0, distance - reach)
        seen[seen] = before <= np.where(self._own[hit], SKIN, SURFACE)
        return seen

    def _in_picture(self, offset: FloatArray) -> BoolArray:
        x, y, backward = (offset @ self._axes).T
        limit = -backward * self._half_height
        return np.asarray((limit > 0) & (np.abs(y) <= limit) & (np.abs(x) <= ASPECT * limit))
