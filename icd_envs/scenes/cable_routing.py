"""The cable routing scene: where clips and cable stand, and how it is drawn and built."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from icd_envs.api import Float64Array
from icd_envs.scenes import layers
from icd_envs.scenes.boxes import Box
from icd_envs.scenes.cable import CABLES, DEFAULT_CABLE, CableKind, CableSpec, add_cable
from icd_envs.scenes.clip import Clip, add_clip

if TYPE_CHECKING:
    from dm_control import mjcf

Contact = Literal["through", "behind", "free"]
"""How the cable is to pass a clip: through its throat, along its back, or without touching it."""
CONTACTS: Final[tuple[Contact, ...]] = ("through", "behind", "free")
ROUTED: Final[tuple[Contact, ...]] = ("through",)

ANCHOR: Final = (0.0, 0.0, 0.04)
"""[m] the fixed end, a few centimetres above the floor."""

WORKSPACE: Final = ((-1.1, -1.1, 0.012), (1.1, 1.1, 0.6))
"""[m] lower and upper limits of the gripper, for a cable of 1 m; a longer one has more room."""

EXTRA_LINKS: Final = 7
"""Links (35 cm) that the cable gains with every clip beyond the second: one more distance."""

START_BEARING: Final = (-np.pi / 2 - 0.15, -np.pi / 2 + 0.15)
"""[rad] the cable starts about 90 degrees away from the route."""

FIRST_BEARING: Final = (-0.15, 0.45)
"""[rad] of clip 1 from the anchor."""
FIRST_DISTANCE: Final = (0.25, 0.38)
"""[m]"""
TURNS: Final = ((-0.8, -0.3),)
"""[rad] the route turns right at clip 1, into its wall: the mouth opens to the left."""
LONG_TURNS: Final = ((-0.9, -0.6), (0.35, 0.6), (-0.3, -0.1))
"""[rad] the same with 3 and 4 clips. Clip 3 must lie to the right of the arm that is swept into
clip 1, whose mouth is on the same side, and clip 4 to the left of the one swept into clip 2: or
the arm goes into these first. A zig-zag that grows flatter does both."""
NEXT_DISTANCE: Final = (0.26, 0.36)
"""[m]"""
AXIS_JITTER: Final = (-0.3, 0.3)
"""[rad] of the throat's axis about the route."""

PERTURBED_ACROSS: Final = 0.08
"""[m] by which every clip is moved at least, out of or against its mouth, in a perturbed scene:
more than the throat is wide, or a cable that is led along the old places still ends up in it."""
PERTURBED_DISTANCE: Final = 0.18
"""[m] by which it is moved at most."""
PERTURB_DRAWS: Final = 1000
"""Scenes drawn in search of a perturbed one."""
PERTURBED_TURN: Final = (0.17, 0.7)
"""[rad] by which it is turned, either way: 10 to 40 degrees."""

GRASP_SOLREF: Final = (0.01, 1.0)
GRASP_SOLIMP: Final = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Stiffness of the grasp: a taut cable stays within 6 mm of the fingers, not 22 mm."""

CAMERAS: Final = (
    ("overview", (1.45, -1.40, 1.05), (0.38, -0.24, 0.0)),
    ("side", (0.45, -0.95, 0.35), (0.42, -0.05, 0.06)),
    ("top", (0.35, -0.25, 1.7), (0.35, -0.2499, 0.0)),
)
"""Name, position [m], point looked at [m], for a cable of 1 m; scaled with its length."""


@dataclass(frozen=True)
class CableRoutingScene:
    """One drawn scene.

    Attributes:
        clips: in the order of the route; their mouths open to alternating sides, so that the
            route is an S.
        contacts: what the expert is to do at each clip.
        start_bearing: [rad] direction of the straight cable at the start.
        anchor: (3,) [m] fixed end of the cable.
        cable: mechanics.
    """

    clips: tuple[Clip, ...]
    contacts: tuple[Contact, ...]
    start_bearing: float
    anchor: Float64Array
    cable: CableSpec = DEFAULT_CABLE

    @property
    def clip_poses(self) -> Float64Array:
        """(F, 3) position x, y [m] and yaw [rad] of every clip."""
        return np.array([clip.pose for clip in self.clips])

    def boxes(self) -> list[Box]:
        """Every solid part of every fixture."""
        return [box for clip in self.clips for box in clip.boxes()]


def cable_for(kind: CableKind, num_fixtures: int) -> CableSpec:
    """A cable long enough for that many clips, with links of the same length."""
    spec = CABLES[kind]
    links = spec.links + EXTRA_LINKS * max(0, num_fixtures - 2)
    return replace(spec, length=spec.length * links / spec.links, links=links)


def draw_scene(
    rng: np.random.Generator, num_fixtures: int = 2, cable: CableSpec = DEFAULT_CABLE
) -> CableRoutingScene:
    """Clips at random places, mouths by turns to the left and to the right of the route.

    Args:
        rng: source of every draw.
        num_fixtures: number of clips, 1 to 4.
        cable: mechanics.
    """
    start_bearing = rng.uniform(*START_BEARING)
    headings = [rng.uniform(*FIRST_BEARING)]
    limits = TURNS if num_fixtures <= 2 else LONG_TURNS
    turns = [rng.uniform(*limit) for limit in limits[: num_fixtures - 1]]
    places = [rng.uniform(*FIRST_DISTANCE) * _direction(headings[0])]
    for turn in turns:
        headings.append(headings[-1] + turn)
        places.append(places[-1] + rng.uniform(*NEXT_DISTANCE) * _direction(headings[-1]))
    # Each throat lies halfway through the route's turn, the last one along the route.
    axes = np.array(headings) + np.array([*turns, 0.0]) / 2
    axes += rng.uniform(*AXIS_JITTER, size=num_fixtures)
    clips = tuple(
        Clip((float(x), float(y)), float(axis + (np.pi / 2 if i % 2 == 0 else -np.pi / 2)))
        for i, ((x, y), axis) in enumerate(zip(places, axes, strict=True))
    )
    return CableRoutingScene(
        clips, ROUTED * num_fixtures, float(start_bearing), np.array(ANCHOR), cable
    )


def draw_contacts(rng: np.random.Generator, num_fixtures: int) -> tuple[Contact, ...]:
    """How to pass each clip, at least one of them through its throat.

    Without a clip to pass through, an untouched cable would meet the goal.
    """
    while True:
        drawn = rng.integers(len(CONTACTS), size=num_fixtures)
        contacts = tuple(CONTACTS[i] for i in drawn)
        if "through" in contacts:
            return contacts


def perturb(scene: CableRoutingScene, rng: np.random.Generator) -> CableRoutingScene | None:
    """Another scene of the same kind, in which every clip stands elsewhere and otherwise turned.

    Scenes are drawn until one fits (on average 50 with two clips, 1300 with four), so that
    perturbed scenes are as solvable as any. For some scenes hardly any other fits.

    Args:
        scene: what to perturb; contacts and cable are kept.
        rng: source of every draw.

    Returns:
        The other scene, or None if none of ``PERTURB_DRAWS`` fits.
    """
    for _ in range(PERTURB_DRAWS):
        other = draw_scene(rng, len(scene.clips), scene.cable)
        moved = other.clip_poses - scene.clip_poses
        mouths = np.stack([clip.mouth[:2] for clip in scene.clips])
        across = np.abs(np.sum(moved[:, :2] * mouths, axis=1))
        distance, turn = np.linalg.norm(moved[:, :2], axis=1), np.abs(moved[:, 2])
        fits = (across >= PERTURBED_ACROSS) & (distance <= PERTURBED_DISTANCE)
        fits &= (turn >= PERTURBED_TURN[0]) & (turn <= PERTURBED_TURN[1])
        if np.all(fits):
            return replace(other, contacts=scene.contacts)
    return None


def _direction(angle: float) -> Float64Array:
    return np.array([np.cos(angle), np.sin(angle)])


def build_scene(scene: CableRoutingScene) -> mjcf.RootElement:
    """The scene as a PyMJCF model, the gripper holding the cable's free end."""
    from icd_envs.scenes.arena import add_camera, make_arena
    from icd_envs.scenes.gripper import add_gripper

    root = make_arena("cable_routing")
    for i, clip in enumerate(scene.clips):
        add_clip(root, clip, f"clip_{i}")
    root.worldbody.add(
        "geom", name="anchor", type="cylinder", size=[0.012, scene.anchor[2] / 2],
        pos=[*scene.anchor[:2], scene.anchor[2] / 2], rgba=[0.35, 0.36, 0.38, 1],
        **layers.VISUAL,
    )  # fmt: skip
    scale = scene.cable.length / DEFAULT_CABLE.length
    for name, position, look_at in CAMERAS:
        add_camera(root, name, [scale * x for x in position], [scale * x for x in look_at])
    add_cable(root, scene.cable, scene.anchor, scene.start_bearing)
    workspace = scale * np.array(WORKSPACE)
    workspace[0, 2] = WORKSPACE[0][2]  # the floor stays where it is
    add_gripper(root, workspace)
    root.equality.add(
        "connect", name="grasp", site1="grasp", site2=f"node_{scene.cable.links}",
        solref=GRASP_SOLREF, solimp=GRASP_SOLIMP,
    )  # fmt: skip
    return root
