"""What an environment observes: its spaces, the clouds of its scenes, and the full observation."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from gymnasium import spaces

from icd_envs.api import Float32Array, Observation
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.physics.guard import BOUND
from icd_envs.physics.plant import Plant
from icd_envs.scenes.boxes import Box
from icd_envs.tasks.partial import mask_spaces

SCENE_POINTS: Final = 1000
FLOOR_POINTS: Final = 200


def observation_space(cloud: tuple[int, ...], *, partial: bool) -> spaces.Dict:
    """The space of ``icd_envs.api.Observation``.

    Args:
        cloud: shape of the object's cloud.
        partial: with the masks of ``icd_envs.api.PartialObservation``.
    """
    shapes: dict[str, tuple[int, ...]] = {
        "observation": (6,),
        "achieved_goal": cloud,
        "desired_goal": cloud,
        "scene": (SCENE_POINTS, 3),
        "goal_scene": (SCENE_POINTS, 3),
    }
    parts: dict[str, spaces.Space[Any]] = {
        name: spaces.Box(-BOUND, BOUND, shape, np.float32) for name, shape in shapes.items()
    }
    if partial:
        parts.update(mask_spaces(shapes))
    return spaces.Dict(parts)


def sample_boxes(boxes: list[Box], rng: np.random.Generator) -> Float32Array:
    """(1000, 3) [m] the cloud of a scene.

    Args:
        boxes: every solid part of it but the floor.
        rng: source of the points.
    """
    return sample_scene(boxes, SCENE_POINTS, FLOOR_POINTS, rng)


class SceneClouds(NamedTuple):
    """What an episode shows of its scenes.

    Attributes:
        scene: (1000, 3) [m] of the present scene.
        goal_scene: (1000, 3) [m] of the goal's.
    """

    scene: Float32Array
    goal_scene: Float32Array


def observe(plant: Plant, goal: Float32Array, clouds: SceneClouds) -> Observation:
    """The full observation of a state.

    Args:
        plant: the scene in that state.
        goal: (N, 3) [m] object cloud to reach.
        clouds: of its scenes.
    """
    return {
        "observation": plant.motion(),
        "achieved_goal": plant.points(),
        "desired_goal": goal,
        "scene": clouds.scene,
        "goal_scene": clouds.goal_scene,
    }
