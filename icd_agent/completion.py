"""What a partial observation shows, and where the rest of the object is."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.interpolate import RBFInterpolator

from icd_envs.api import Float32Array, FloatArray, Observation
from icd_envs.errors import InvalidObservationError

SMOOTHING: Final = 0.01
"""[m] in the material; evens out a depth camera's noise of 2 mm per axis."""


def seen_scene(observation: Observation) -> FloatArray:
    """Points (M, 3) [m] of the present scene that were seen, world frame.

    Raises:
        InvalidObservationError: none was.
    """
    mask, scene = observation.get("scene_mask"), observation["scene"]
    seen = scene if mask is None else scene[np.asarray(mask) > 0]
    if not len(seen):
        raise InvalidObservationError(
            "scene_mask is 0 everywhere: no point of the scene is seen, and nothing can be planned "
            "in it; begin where the camera sees some"
        )
    return seen


class Completion:
    """Guesses hidden points from seen ones that are near in the material.

    An observation says where a hidden point is as (0, 0, 0), half a metre from the object: whoever
    measures distances between clouds must not take that for its place.
    """

    def __init__(self, canonical: FloatArray) -> None:
        """Begin an episode.

        Args:
            canonical: (N, 3) [m] the object in its own frame, ``Episode.canonical_cloud``.
        """
        self._canonical = np.asarray(canonical, np.float64)
        self._last: Float32Array | None = None

    def __call__(self, observation: Observation) -> Observation:
        """Return the observation with every point of the object somewhere; call once per step.

        A full observation is returned as it is. Of a partial one the last guess replaces the
        object's cloud, moved by what is seen to have moved: a smooth interpolation over the
        material. The first one begins with the object in its own frame, at the hand.

        Args:
            observation: not changed.
        """
        mask = observation.get("achieved_goal_mask")
        if mask is None:
            return observation
        if self._last is None:
            # Nothing is known but the hand that holds it.
            self._last = (self._canonical + observation["observation"][:3]).astype(np.float32)
        seen = np.asarray(mask) > 0
        if seen.any():
            moved = observation["achieved_goal"][seen].astype(np.float64) - self._last[seen]
            guess = RBFInterpolator(
                self._canonical[seen], moved, kernel="linear", degree=0, smoothing=SMOOTHING
            )
            self._last = (self._last + guess(self._canonical)).astype(np.float32)
        return {**observation, "achieved_goal": self._last}
