"""The C-clip that a cable is routed through.

Local frame: origin on the floor below the throat's centre, y along the throat (the cable's
direction when routed), x out of the mouth, z up. A back wall stands behind the throat, an upper
lip hinged at the wall's top slopes up and out over it, a base plate lies behind the wall. The
floor closes the C from below: a lower jaw in front of the wall stops a sagging cable.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from icd_envs.api import Float64Array, FloatArray
from icd_envs.scenes import layers
from icd_envs.scenes.boxes import Box, rotation_y, rotation_z
from icd_envs.scenes.layers import CONTACT_MARGIN

if TYPE_CHECKING:
    from dm_control import mjcf

WIDTH: Final = 0.036
"""[m] along the throat."""
WALL_X: Final = -0.03
WALL_THICKNESS: Final = 0.02
WALL_HEIGHT: Final = 0.07
WALL_BACK: Final = WALL_X - WALL_THICKNESS / 2
"""[m] local x of the wall's back face."""
LIP_LENGTH: Final = 0.095
LIP_THICKNESS: Final = 0.012
LIP_TILT: Final = np.deg2rad(17.0)
BASE_LENGTH: Final = 0.05
BASE_THICKNESS: Final = 0.008

RGBA = (0.55, 0.57, 0.6, 1.0)


def _local_boxes() -> dict[str, Box]:
    upright = np.eye(3)
    tilt = rotation_y(-LIP_TILT)
    front = WALL_X + WALL_THICKNESS / 2
    hinge = np.array([WALL_BACK, 0.0, WALL_HEIGHT])
    lip = np.array([LIP_LENGTH, WIDTH, LIP_THICKNESS]) / 2
    return {
        "wall": Box(
            np.array([WALL_X, 0.0, WALL_HEIGHT / 2]),
            np.array([front - WALL_BACK, WIDTH, WALL_HEIGHT]) / 2,
            upright,
        ),
        "lip": Box(hinge + tilt @ np.array([lip[0], 0.0, lip[2]]), lip, tilt),
        "base": Box(
            np.array([WALL_BACK - BASE_LENGTH / 2, 0.0, BASE_THICKNESS / 2]),
            np.array([BASE_LENGTH, WIDTH + 0.02, BASE_THICKNESS]) / 2,
            upright,
        ),
    }


LOCAL_BOXES: Final = _local_boxes()

HeightT = TypeVar("HeightT", float, FloatArray)

THROAT_X: Final = (
    WALL_X + WALL_THICKNESS / 2,
    WALL_BACK + LIP_LENGTH * float(np.cos(LIP_TILT)),
)
"""[m] the throat reaches from the wall's face to below the lip's end."""


def throat_height(x: HeightT) -> HeightT:
    """Height [m] of the lip's underside above the floor at local ``x`` [m], any shape."""
    return WALL_HEIGHT + (x - WALL_BACK) * float(np.tan(LIP_TILT))


@dataclass(frozen=True)
class Clip:
    """A clip standing on the floor.

    Attributes:
        position: (2,) [m] of the throat's centre.
        yaw: [rad] direction of the mouth, local x, in the horizontal plane.
    """

    position: tuple[float, float]
    yaw: float

    @property
    def pose(self) -> Float64Array:
        """(3,) position x, y [m] and yaw [rad]."""
        return np.array([*self.position, self.yaw])

    @property
    def origin(self) -> Float64Array:
        """(3,) [m] origin of the local frame."""
        return np.array([*self.position, 0.0])

    @property
    def mouth(self) -> Float64Array:
        """(3,) unit vector out of the mouth."""
        return rotation_z(self.yaw)[:, 0]

    @property
    def axis(self) -> Float64Array:
        """(3,) unit vector along the throat."""
        return rotation_z(self.yaw)[:, 1]

    def boxes(self) -> list[Box]:
        """The clip's solid parts in the world frame."""
        rotation = rotation_z(self.yaw)
        return [box.moved(rotation, self.origin) for box in LOCAL_BOXES.values()]


def add_clip(root: mjcf.RootElement, clip: Clip, name: str) -> None:
    """Add a clip to a scene."""
    body = root.worldbody.add(
        "body", name=name, pos=clip.origin, quat=[np.cos(clip.yaw / 2), 0, 0, np.sin(clip.yaw / 2)]
    )
    for part, box in LOCAL_BOXES.items():
        x, z = box.rotation[:, 0], box.rotation[:, 2]
        quat = [np.cos(a := np.arctan2(-x[2], z[2]) / 2), 0, np.sin(a), 0]
        body.add(
            "geom", name=f"{name}_{part}", type="box", pos=box.center, size=box.half, quat=quat,
            friction=[0.3, 0.005, 0.0001], margin=CONTACT_MARGIN, rgba=RGBA,
            **layers.FIXTURE,
        )  # fmt: skip
