"""Oriented boxes: the one primitive all fixtures are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from icd_envs.api import Float64Array


@dataclass(frozen=True)
class Box:
    """An oriented box.

    Attributes:
        center: (3,) [m].
        half: (3,) [m] half extents along its own axes.
        rotation: (3, 3) columns are its axes.
    """

    center: Float64Array
    half: Float64Array
    rotation: Float64Array

    def moved(self, rotation: Float64Array, translation: Float64Array) -> Box:
        """The box seen from a frame in which its old frame has the given pose."""
        return Box(rotation @ self.center + translation, self.half, rotation @ self.rotation)


def rotation_z(angle: float) -> Float64Array:
    """(3, 3) rotation about z by ``angle`` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotation_y(angle: float) -> Float64Array:
    """(3, 3) rotation about y by ``angle`` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
