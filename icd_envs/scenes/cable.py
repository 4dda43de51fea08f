"""A cable as a chain of capsules joined by twist-free universal joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from icd_envs.api import Float64Array
from icd_envs.drawing import OBJECT_RGBA
from icd_envs.scenes import layers

if TYPE_CHECKING:
    from dm_control import mjcf


@dataclass(frozen=True)
class CableSpec:
    """Mechanics of one kind of cable.

    Attributes:
        length: [m].
        radius: [m].
        links: number of rigid links.
        density: [kg/m] mass per length.
        stiffness: [N m/rad] of each bending hinge.
        damping: [N m s/rad] of each bending hinge.
        armature: [kg m^2] added rotor inertia; without it 2-11 of 80 random rollouts diverged.
        friction: sliding friction against fixtures and floor.
    """

    length: float = 1.0
    radius: float = 0.005
    links: int = 20
    density: float = 0.08
    stiffness: float = 0.02
    damping: float = 2e-3
    armature: float = 1e-4
    friction: float = 0.3


CableKind = Literal["default", "charging", "ethernet", "rope"]

DEFAULT_CABLE: Final = CableSpec()

CABLES: Final[dict[CableKind, CableSpec]] = {
    "default": DEFAULT_CABLE,
    "charging": CableSpec(radius=0.0035, density=0.03, stiffness=0.006, damping=1e-3),
    "ethernet": CableSpec(radius=0.004, density=0.05, stiffness=0.08, damping=4e-3),
    "rope": CableSpec(radius=0.008, density=0.14, stiffness=0.008, damping=6e-3, friction=0.45),
}
"""A cable of bending stiffness EI [N m^2] has hinges of EI / (5 cm), in N m/rad.

charging: soft and thin, EI 3e-4 as a USB lead's. Real ones have radius 2 mm; the hand moves 3 mm
    per physics step, and a cable thinner than that could be pulled through a wall.
ethernet: stiff, EI 4e-3, a round patch cord.
rope: thick, heavy and rough, hardly any elastic stiffness but friction between its strands.
"""


def add_cable(root: mjcf.RootElement, spec: CableSpec, anchor: Float64Array, yaw: float) -> None:
    """Add a straight cable, fixed at one end, with its nodes as position sensors.

    Node i (site ``node_i``) is the start of link i; the last node is the free tip (body
    ``link_{links-1}``), which the gripper holds. Each link has one capsule against fixtures and
    one sphere against the floor: half the contacts that capsules would make there.

    Args:
        root: scene to add to.
        spec: mechanics.
        anchor: (3,) [m] fixed end.
        yaw: [rad] direction in the horizontal plane of the straight cable.
    """
    step = spec.length / spec.links
    body = root.worldbody.add(
        "body", name="link_0", pos=anchor, quat=[np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
    )
    for i in range(spec.links):
        if i:
            body = body.add("body", name=f"link_{i}", pos=[step, 0, 0])
        for axis, direction in (("z", [0, 0, 1]), ("y", [0, 1, 0])):
            body.add(
                "joint",
                name=f"bend_{axis}_{i}",
                type="hinge",
                axis=direction,
                stiffness=spec.stiffness if i else 0.0,
                damping=spec.damping,
                armature=spec.armature,
            )
        body.add(
            "geom",
            name=f"cable_{i}",
            type="capsule",
            fromto=[0, 0, 0, step, 0, 0],
            size=[spec.radius],
            mass=spec.density * step,
            friction=[spec.friction, 0.005, 0.0001],
            rgba=OBJECT_RGBA,
            **layers.CABLE,
        )
        body.add(
            "geom",
            name=f"cable_floor_{i}",
            type="sphere",
            pos=[step, 0, 0],
            size=[spec.radius],
            mass=0,
            friction=[spec.friction, 0.005, 0.0001],
            rgba=OBJECT_RGBA,
            **layers.CABLE_FLOOR,
        )
        body.add("site", name=f"node_{i}", pos=[0, 0, 0], size=[0.001])
        root.sensor.add("framepos", name=f"node_{i}", objtype="site", objname=f"node_{i}")
    body.add("site", name=f"node_{spec.links}", pos=[step, 0, 0], size=[0.001])
    last = f"node_{spec.links}"
    root.sensor.add("framepos", name=last, objtype="site", objname=last)
