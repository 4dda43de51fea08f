"""The cost space of places, in a frame that scene and object give at the start of an episode."""

from __future__ import annotations

from typing import Literal

import numpy as np

from icd_agent.chain import Features, Placed
from icd_agent.completion import seen_scene
from icd_agent.field.field import SceneField
from icd_agent.scene_tokens import Frame, scene_tokens
from icd_envs.api import Float32Array, FloatArray, Observation


class ScenePoints:
    """Places of the object's points; distances are metres, as in the world's frame.

    Unlike the world's, the frame is the same for scenes that differ by a turn about gravity or a
    shift, so that a network can be trained on what it sees in it.
    """

    def __init__(
        self, field: SceneField, goal: Literal["in place", "in its scene"] = "in its scene"
    ) -> None:
        """Choose.

        Args:
            field: tells fixtures from the floor, in evaluation mode.
            goal: "in its scene" gives the goal's places in the frame of the scene that it was
                specified in; "in place" where it lies in the world, as if it were of the present
                scene. They differ in the adaptation tasks only.
        """
        self._field = field
        self._goal = goal

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        """Find the frames of the present scene and, if it is another, of the goal's."""
        middle = observation["achieved_goal"].mean(axis=0)
        frame = scene_tokens(self._field, seen_scene(observation)).frame(middle)
        there = frame
        if foreign and self._goal == "in its scene":
            there = scene_tokens(self._field, observation["goal_scene"]).frame(middle)
        return Placed(placed_in(frame), placed_in(there), _back_from(frame))


def placed_in(frame: Frame) -> Features:
    """Features of clouds (..., N, 3) [m]: where they are in a frame."""

    def features(points: FloatArray) -> Float32Array:
        return frame.place(points).astype(np.float32)

    return features


def _back_from(frame: Frame) -> Features:
    def clouds(features: FloatArray) -> Float32Array:
        return frame.back(features).astype(np.float32)

    return clouds
