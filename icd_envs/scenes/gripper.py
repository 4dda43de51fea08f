"""A floating hand: a wide palm above two fingers, moved by three velocity-controlled slides.

The hand's origin is the point between its fingertips. Slides are velocity servos with limited
force, so a blocked hand neither winds up nor pushes through a fixture, and the whole state is in
position and velocity: no hidden set point.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from icd_envs.api import Float32Array, Float64Array
from icd_envs.scenes import layers

if TYPE_CHECKING:
    from dm_control import mjcf

MASS: Final = 0.5
"""[kg], without gravity."""
SERVO_GAIN: Final = 100.0
"""[N s/m] velocity error to force."""
FORCE_LIMIT: Final = 5.0
"""[N] per axis."""

PALM_CENTER: Final = (0.0, 0.0, 0.085)
PALM_HALF: Final = (0.025, 0.09, 0.03)
FINGER_HALF: Final = (0.01, 0.006, 0.0275)
FINGER_OFFSET: Final = 0.012
FINGER_Z: Final = 0.0275

RGBA = (0.93, 0.93, 0.94, 1.0)


def gripper_spheres() -> Float32Array:
    """(S, 4) spheres about as large as the hand: centre relative to its origin [m] and radius [m].

    The edges of its boxes stick out by up to 13 mm, and the spheres of the boxes by up to 15.
    """
    palm = [[PALM_CENTER[0], y, PALM_CENTER[2], 0.03] for y in (-0.075, -0.038, 0.0, 0.038, 0.075)]
    fingers = [[0.0, 0.0, z, 0.018] for z in (0.01, 0.04)]
    return np.array(palm + fingers, dtype=np.float32)


def add_gripper(root: mjcf.RootElement, workspace: Float64Array) -> None:
    """Add the hand with slides ``slide_x|y|z`` whose joint positions are world coordinates.

    Args:
        root: scene to add to.
        workspace: (2, 3) [m] lower and upper limits of the slides.
    """
    body = root.worldbody.add("body", name="gripper", pos=[0, 0, 0], gravcomp=1)
    for i, axis in enumerate("xyz"):
        joint = body.add(
            "joint", name=f"slide_{axis}", type="slide", axis=np.eye(3)[i],
            limited=True, range=workspace[:, i],
        )  # fmt: skip
        root.actuator.add(
            "velocity", name=f"slide_{axis}", joint=joint, kv=SERVO_GAIN, ctrllimited=False,
            forcelimited=True, forcerange=[-FORCE_LIMIT, FORCE_LIMIT],
        )  # fmt: skip
    body.add(
        "geom", name="palm", type="box", pos=PALM_CENTER, size=PALM_HALF, mass=0.8 * MASS,
        rgba=RGBA, **layers.GRIPPER,
    )  # fmt: skip
    for name, side in (("left", 1), ("right", -1)):
        body.add(
            "geom", name=f"finger_{name}", type="box", pos=[0, side * FINGER_OFFSET, FINGER_Z],
            size=FINGER_HALF, mass=0.1 * MASS, rgba=RGBA, **layers.GRIPPER,
        )  # fmt: skip
    body.add("site", name="grasp", pos=[0, 0, 0], size=[0.002])
