"""Gauss linking number of closed polygons: the oracle of the routing test."""

from __future__ import annotations

import numpy as np

from icd_envs.api import Float64Array
from icd_envs.scenes.boxes import Box, rotation_z
from icd_envs.scenes.clip import LOCAL_BOXES, Clip

SKY = 10.0
"""[m] height at which a cable is closed, far above every clip."""


def linking_number(first: Float64Array, second: Float64Array) -> float:
    """Exact Gauss integral over all pairs of segments of two closed polygons.

    Klenin and Langowski, Biopolymers 54 (2000), method 1a: each pair contributes the signed area
    of a spherical quadrilateral.

    Args:
        first: (N, 3) corners; the last is joined to the first.
        second: (M, 3) likewise.
    """
    r1, r2 = first[:, None], np.roll(first, -1, axis=0)[:, None]
    r3, r4 = second[None], np.roll(second, -1, axis=0)[None]
    normals = [
        np.cross(r3 - r1, r4 - r1),
        np.cross(r4 - r1, r4 - r2),
        np.cross(r4 - r2, r3 - r2),
        np.cross(r3 - r2, r3 - r1),
    ]
    units = [n / np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-300) for n in normals]
    area = np.zeros(np.broadcast_shapes(r1.shape, r3.shape)[:-1])
    for a, b in zip(units, [*units[1:], units[0]], strict=True):
        area = area + np.arcsin(np.clip(np.sum(a * b, axis=-1), -1.0, 1.0))
    sign = np.sign(np.sum(np.cross(r4 - r3, r2 - r1) * (r3 - r1), axis=-1))
    return float(np.sum(sign * area) / (4 * np.pi))


def clip_loop(clip: Clip) -> Float64Array:
    """(4, 3) [m] up the wall, along the lip, down a virtual segment, back along the floor.

    Read off the clip's solid parts; right-handed about its axis.
    """
    pose = rotation_z(clip.yaw), clip.origin
    wall, lip = LOCAL_BOXES["wall"].moved(*pose), LOCAL_BOXES["lip"].moved(*pose)
    foot = _corner(wall, 1, -1)
    inner, end = _corner(lip, -1, -1), _corner(lip, 1, -1)
    share = np.dot(foot - inner, clip.mouth) / np.dot(end - inner, clip.mouth)
    below = np.array([end[0], end[1], foot[2]])
    return np.array([foot, inner + share * (end - inner), end, below])


def closed(cable: Float64Array) -> Float64Array:
    """The cable, closed by going straight up from its ends: no vertical passes a throat."""
    return np.concatenate([cable, [[*cable[-1, :2], SKY], [*cable[0, :2], SKY]]])


def _corner(box: Box, x: int, z: int) -> Float64Array:
    return box.center + box.rotation @ (np.array([x, 0, z]) * box.half)
