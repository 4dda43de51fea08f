"""The partial observation: what one camera sees of object and scene, with noise."""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np
from gymnasium import spaces

from icd_envs.api import SEEN_CLOUDS, Observation, PartialObservation
from icd_envs.physics.camera import PointCamera
from icd_envs.physics.guard import BOUND

CAMERA: Final = "overview"
"""Not the camera of the pictures: how an episode is drawn changes nothing in it."""
NOISE: Final = 0.002
"""[m] standard deviation per axis, that of a depth camera at about 2 m."""
UNSEEN: Final = 0.0
"""[m] coordinates of a point that is not seen: what masked pooling expects, a value of the space,
and one that says nothing of where the point is."""


def mask_spaces(shapes: dict[str, tuple[int, ...]]) -> dict[str, spaces.Box]:
    """Spaces of the masks: 1 where a point is seen, else 0.

    Args:
        shapes: of the full observation's clouds, by name.
    """
    return {
        f"{name}_mask": spaces.Box(0.0, 1.0, shapes[name][:1], np.float32) for name in SEEN_CLOUDS
    }


def look(
    model: mujoco.MjModel, data: mujoco.MjData, full: Observation, rng: np.random.Generator
) -> PartialObservation:
    """Hide what the camera does not see and add noise to what it does; goals stay as they are.

    Args:
        model: the scene.
        data: state; its positions must be up to date.
        full: the full observation of that state; left as it is.
        rng: source of the noise.
    """
    sizes = [len(full["achieved_goal"]), len(full["scene"])]
    points = np.concatenate([full["achieved_goal"], full["scene"]])
    seen = PointCamera(model, CAMERA).sees(data, points)
    noisy = points + rng.normal(0.0, NOISE, points.shape)
    shown = np.where(seen[:, None], np.clip(noisy, -BOUND, BOUND), UNSEEN).astype(np.float32)
    cloud, scene = np.split(shown, sizes[:1])
    cloud_mask, scene_mask = np.split(seen.astype(np.float32), sizes[:1])
    return {
        **full,
        "achieved_goal": cloud,
        "achieved_goal_mask": cloud_mask,
        "scene": scene,
        "scene_mask": scene_mask,
    }
