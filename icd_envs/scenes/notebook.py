"""A notebook as a tree of strips that hangs from the gripper: no loop, no equality constraint.

The first strip turns on a hinge at the edge the gripper holds. Between strips lie a bend hinge
across the sheet and a stiff twist hinge along it: covers bend little, the spine bends freely.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from icd_envs.api import Float64Array
from icd_envs.drawing import OBJECT_RGBA
from icd_envs.scenes import layers

if TYPE_CHECKING:
    from dm_control import mjcf


@dataclass(frozen=True)
class NotebookSpec:
    """Size and mechanics of a notebook.

    Attributes:
        width: [m] along the held edge.
        cover: [m] from the held edge to the spine, and from the spine to the free edge.
        spine: [m] between the covers.
        cover_strips: rigid strips of each cover.
        spine_strips: rigid strips of the spine.
        mass: [kg] spread evenly.
        radius: [m] of the contact spheres: half the thickness of the sheet.
        cover_stiffness: [N m/rad] of a bend hinge inside a cover.
        spine_stiffness: [N m/rad] of a bend hinge at or in the spine.
        twist_stiffness: [N m/rad] of every twist hinge.
        damping: [N m s/rad] of every other hinge; with 2e-3 a notebook at rest kept trembling.
        grip_damping: [N m s/rad] of the hinge at the held edge: fingers that pinch it. With 5e-3
            it swung like a pendulum for a second and could be flung over in one move.
        armature: [kg m^2] added rotor inertia of every hinge; it also did with 1e-5.
        cover_limit: [rad] largest bend of a hinge inside a cover.
        spine_limit: [rad] largest bend of a hinge at or in the spine; together they close it.
        friction: sliding friction.
    """

    width: float = 0.17
    cover: float = 0.15
    spine: float = 0.02
    cover_strips: int = 3
    spine_strips: int = 2
    mass: float = 0.05
    radius: float = 0.004
    cover_stiffness: float = 0.08
    spine_stiffness: float = 0.003
    twist_stiffness: float = 0.5
    damping: float = 5e-3
    grip_damping: float = 0.01
    armature: float = 1e-4
    cover_limit: float = 0.5
    spine_limit: float = float(np.pi / 3)
    friction: float = 0.4

    @property
    def length(self) -> float:
        """[m] from the held edge to the free one."""
        return 2 * self.cover + self.spine

    @property
    def strips(self) -> Float64Array:
        """(S,) [m] length of every strip, from the held edge on."""
        cover = [self.cover / self.cover_strips] * self.cover_strips
        return np.array([*cover, *[self.spine / self.spine_strips] * self.spine_strips, *cover])

    @property
    def edges(self) -> Float64Array:
        """(S + 1,) [m] distance of every strip's edge from the held one."""
        return np.concatenate([[0.0], np.cumsum(self.strips)])

    def in_spine(self, strip: int) -> bool:
        """Whether a strip belongs to the spine."""
        return self.cover_strips <= strip < self.cover_strips + self.spine_strips

    def is_free(self, strip: int) -> bool:
        """Whether a strip belongs to the cover that the gripper does not hold."""
        return strip >= self.cover_strips + self.spine_strips


DEFAULT_NOTEBOOK: Final = NotebookSpec()

SPINE_RGBA: Final = (0.8, 0.62, 0.05, 1.0)
STRIPE_RGBA: Final = (1.0, 0.95, 0.6, 1.0)
STRIPE_WIDTH: Final = 0.02
"""[m] of the light stripe along the middle of the held cover."""
SIDES: Final = (1.0, -1.0)
"""Left and right, in half widths: the order of the two tracked nodes of every edge."""


def add_notebook(gripper: mjcf.Element, spec: NotebookSpec) -> None:
    """Hang a flat notebook from the gripper's origin, its free edge toward -x.

    Nodes ``node_{2 e}`` and ``node_{2 e + 1}`` are the left and right end of edge e, counted from
    the held edge; each is a position sensor. Contacts are spheres at the ends and the middle of
    every edge. The held cover's spheres also touch the free cover's boxes: the notebook closes
    on itself.

    Args:
        gripper: body to hang it from.
        spec: size and mechanics.
    """
    body, place = gripper, 0.0
    for strip, length in enumerate(spec.strips):
        body = body.add("body", name=f"strip_{strip}", pos=[place, 0, 0])
        _add_joints(body, spec, strip)
        _add_box(body, spec, strip, float(length))
        _add_edge(body, spec, strip, 0.0)
        place = -float(length)
    _add_edge(body, spec, len(spec.strips), place)


def _add_joints(body: mjcf.Element, spec: NotebookSpec, strip: int) -> None:
    shared = {"type": "hinge", "armature": spec.armature}
    if strip == 0:
        body.add("joint", name="held_edge", axis=[0, 1, 0], damping=spec.grip_damping, **shared)
        return
    shared["damping"] = spec.damping
    soft = spec.in_spine(strip) or spec.in_spine(strip - 1)
    limit = spec.spine_limit if soft else spec.cover_limit
    body.add(
        "joint", name=f"bend_{strip}", axis=[0, 1, 0], limited=True, range=[-limit, limit],
        stiffness=spec.spine_stiffness if soft else spec.cover_stiffness, **shared,
    )  # fmt: skip
    body.add(
        "joint", name=f"twist_{strip}", axis=[1, 0, 0], stiffness=spec.twist_stiffness, **shared
    )


def _add_box(body: mjcf.Element, spec: NotebookSpec, strip: int, length: float) -> None:
    half = np.array([length, spec.width, 2 * 0.75 * spec.radius]) / 2
    body.add(
        "geom", name=f"sheet_{strip}", type="box", pos=[-length / 2, 0, 0], size=half,
        mass=spec.mass * length / spec.length,
        rgba=SPINE_RGBA if spec.in_spine(strip) else OBJECT_RGBA,
        **(layers.SHEET_FREE if spec.is_free(strip) else layers.SHEET_VISUAL),
    )  # fmt: skip
    if strip < spec.cover_strips:
        body.add(
            "geom", name=f"stripe_{strip}", type="box", mass=0, pos=[-length / 2, 0, 0],
            size=[half[0], STRIPE_WIDTH / 2, half[2] + 2e-4], rgba=STRIPE_RGBA,
            **layers.SHEET_VISUAL,
        )  # fmt: skip


def _add_edge(body: mjcf.Element, spec: NotebookSpec, edge: int, place: float) -> None:
    held = edge < spec.cover_strips
    for name, side in zip(("left", "middle", "right"), (SIDES[0], 0.0, SIDES[1]), strict=True):
        y = side * (spec.width / 2 - spec.radius)
        body.add(
            "geom", name=f"contact_{edge}_{name}", type="sphere", size=[spec.radius], mass=0,
            pos=[place, y, 0], friction=[spec.friction, 0.005, 0.0001],
            **(layers.SHEET_HELD if held else layers.SHEET),
        )  # fmt: skip
    for i, side in enumerate(SIDES):
        name = f"node_{2 * edge + i}"
        body.add("site", name=name, pos=[place, side * spec.width / 2, 0], size=[0.001])
        body.root.sensor.add("framepos", name=name, objtype="site", objname=name)
