"""Through which clips does a cable pass, and in which sense?

The throat of a clip is the part of the plane through its centre, normal to its axis, between wall
and lip end, floor and lip underside. A polyline that passes it along the axis counts +1, against
it -1; a cable is routed when the net count is not zero.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from icd_envs.api import FloatArray
from icd_envs.scenes.clip import THROAT_X, WALL_BACK, WALL_HEIGHT, Clip, throat_height

BEHIND: Final = 0.12
"""[m] a cable that passes no farther behind a clip's wall than this passes behind the clip."""


class Crossing(NamedTuple):
    """Where a cable passes a clip's throat.

    Attributes:
        segment: index of the polyline's segment.
        depth: [m] local x of the pass: negative is toward the wall.
    """

    segment: int
    depth: float


def signed_crossings(points: FloatArray, clips: FloatArray) -> NDArray[np.int64]:
    """Net signed number of passes of a polyline through each clip's throat.

    Args:
        points: (..., N, 3) [m] polylines, world frame.
        clips: (..., F, 3) position x, y [m] and yaw [rad] of each clip.

    Returns:
        (..., F) integers.
    """
    offset = points[..., None, :, :2] - clips[..., :, None, :2]
    cos, sin = np.cos(clips[..., 2])[..., None], np.sin(clips[..., 2])[..., None]
    x = cos * offset[..., 0] + sin * offset[..., 1]
    y = cos * offset[..., 1] - sin * offset[..., 0]
    z = np.broadcast_to(points[..., None, :, 2], x.shape)
    direction = (y[..., 1:] >= 0).astype(np.int64) - (y[..., :-1] >= 0)
    share = -y[..., :-1] / np.where(direction == 0, 1.0, np.diff(y))
    x = x[..., :-1] + share * np.diff(x)
    z = z[..., :-1] + share * np.diff(z)
    inside = (x >= THROAT_X[0]) & (x <= THROAT_X[1]) & (z >= 0) & (z <= throat_height(x))
    return np.sum(direction * inside, axis=-1)


def find_crossing(points: FloatArray, clip: Clip) -> Crossing | None:
    """The first pass through one clip's throat, or None if the net count is zero.

    Args:
        points: (N, 3) [m] polyline, world frame.
        clip: the clip.
    """
    through = _through(points, clip.pose)
    return through[0].crossing if sum(one.direction for one in through) else None


def passes_behind(points: FloatArray, clip: Clip) -> bool:
    """Whether a cable passes the back side of one clip, not higher than its wall.

    Args:
        points: (N, 3) [m] polyline, world frame.
        clip: the clip.
    """
    return bool(
        sum(
            one.direction
            for one in _plane_passes(points, clip.pose)
            if WALL_BACK - BEHIND <= one.crossing.depth <= WALL_BACK and one.height <= WALL_HEIGHT
        )
    )


class _Pass(NamedTuple):
    direction: int
    crossing: Crossing
    height: float


def _through(points: FloatArray, clip: FloatArray) -> list[_Pass]:
    """Passes of one polyline (N, 3) through one throat (3,)."""
    return [
        one
        for one in _plane_passes(points, clip)
        if THROAT_X[0] <= one.crossing.depth <= THROAT_X[1]
        and 0 <= one.height <= throat_height(one.crossing.depth)
    ]


def _plane_passes(points: FloatArray, clip: FloatArray) -> list[_Pass]:
    """Passes of one polyline (N, 3) through one clip's plane, 5 times faster than for batches.

    Experts and collecting look at every step; few segments pass the plane at all.
    """
    cos, sin = np.cos(clip[2]), np.sin(clip[2])
    offset_x, offset_y = points[:, 0] - clip[0], points[:, 1] - clip[1]
    y = cos * offset_y - sin * offset_x
    beyond = y >= 0
    found = []
    for i in np.flatnonzero(beyond[1:] != beyond[:-1]):
        j = i + 1
        share = -y[i] / (y[j] - y[i])
        x = cos * offset_x[i] + sin * offset_y[i]
        x = x + share * (cos * offset_x[j] + sin * offset_y[j] - x)
        z = points[i, 2] + share * (points[j, 2] - points[i, 2])
        found.append(_Pass(1 if beyond[j] else -1, Crossing(int(i), float(x)), float(z)))
    return found
