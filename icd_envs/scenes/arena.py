"""The empty world: floor, light, cameras and solver options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from dm_control import mjcf

from icd_envs.scenes import layers
from icd_envs.scenes.layers import CONTACT_MARGIN

TIMESTEP: Final = 0.005
"""[s] physics step."""

CONTACT_TIME: Final = 0.01
"""[s] time constant of contacts, twice the step: a taut cable sinks 1.5 mm in, not 5 mm."""

SUBSTEPS: Final = 10
"""Physics steps per control step."""

MAX_WIDTH: Final = 1280
MAX_HEIGHT: Final = 960
"""[px] of the largest picture."""


def make_arena(name: str) -> mjcf.RootElement:
    """Floor, light and options tuned for thin chains: see docs/tasks/cable-routing.md."""
    root = mjcf.RootElement(model=name)
    root.compiler.angle = "radian"
    root.option.timestep = TIMESTEP
    root.option.integrator = "implicitfast"
    root.option.cone = "pyramidal"
    root.option.solver = "Newton"
    root.option.iterations = 5
    root.option.jacobian = "dense"
    root.default.geom.solref = [CONTACT_TIME, 1.0]
    # MuJoCo's silent self-reset would hide a divergence; physics.guard looks for it instead.
    root.option.flag.autoreset = "disable"
    getattr(root.visual, "global").offwidth = MAX_WIDTH
    getattr(root.visual, "global").offheight = MAX_HEIGHT
    root.visual.headlight.ambient = [0.35, 0.35, 0.35]
    root.asset.add(
        "texture", name="sky", type="skybox", builtin="gradient", rgb1=[0.78, 0.83, 0.88],
        rgb2=[0.55, 0.62, 0.7], width=64, height=64,
    )  # fmt: skip
    root.asset.add(
        "texture", name="checker", type="2d", builtin="checker",
        rgb1=[0.5, 0.55, 0.6], rgb2=[0.43, 0.48, 0.53], width=256, height=256,
    )  # fmt: skip
    root.asset.add("material", name="checker", texture="checker", texrepeat=[8, 8])
    root.worldbody.add("light", pos=[0.3, -0.5, 2.0], dir=[0, 0.2, -1], castshadow=True)
    root.worldbody.add(
        "geom", name="floor", type="plane", size=[2, 2, 0.1], material="checker",
        friction=[0.3, 0.005, 0.0001], margin=CONTACT_MARGIN, **layers.FLOOR,
    )  # fmt: skip
    return root


def add_camera(
    root: mjcf.RootElement, name: str, position: Sequence[float], look_at: Sequence[float]
) -> None:
    """Add a fixed camera, upright in the picture.

    Args:
        root: scene to add to.
        name: of the camera.
        position: (3,) [m].
        look_at: (3,) [m].
    """
    backward = np.subtract(position, look_at)
    right = np.cross([0.0, 0.0, 1.0], backward)
    up = np.cross(backward, right)
    root.worldbody.add("camera", name=name, pos=position, xyaxes=[*right, *up])
