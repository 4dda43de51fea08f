"""Cable routing: thread a cable, fixed at one end, through every clip (paper, section V-A)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final, Literal

import numpy as np

from icd_envs.api import BoolArray, Float32Array, Float64Array, FloatArray
from icd_envs.experts.cable_routing import CableRoutingExpert, draw_style
from icd_envs.geometry.routing import find_crossing, passes_behind, signed_crossings
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.physics.plant import Plant, TrackedCloud
from icd_envs.scenes.boxes import Box
from icd_envs.scenes.cable import CABLES, CableKind
from icd_envs.scenes.cable_routing import (
    CableRoutingScene,
    cable_for,
    draw_contacts,
    draw_scene,
    perturb,
)
from icd_envs.scenes.cable_routing_xml import scene_xml
from icd_envs.tasks.base import Scenes
from icd_envs.tasks.checks import check_choice, check_integer
from icd_envs.tasks.env import ContactEnv, ObservationMode, RewardType
from icd_envs.tasks.factory import EnvFactory
from icd_envs.tasks.problem import Split

Goals = Literal["routed", "contact"]

CLOUD_POINTS: Final = 200
SLACK: Final = 0.02
"""[m] by which the gripper comes toward the anchor before an episode: the cable hangs free."""
RISE: Final = 0.02
"""[m] by which it rises meanwhile."""
SETTLE_STEPS: Final = (20, 5)
"""Control steps of that motion, and of rest after it."""
UNTOUCHED: Final = 0.01
"""[m] gap between a cable's surface and a clip that it leaves alone."""

MOST_FIXTURES: Final = 4
MAX_STEPS: Final = 300
EXTRA_STEPS: Final = 200
"""Control steps for every clip beyond the second: the cable is longer, and so is every swing."""


@dataclass(frozen=True)
class CableRouting:
    """The task behind ``ICDCableRouting-v0``.

    Attributes:
        num_fixtures: clips to route through, 1 to 4.
        cable: which kind; it is longer with 3 and 4 clips.
        goals: through every clip, or drawn for each: through, behind or free.

    Raises:
        InvalidOptionError: on a value that an attribute cannot take.
    """

    env_id: ClassVar[str] = "ICDCableRouting-v0"
    action_scale: ClassVar[float] = 0.03
    parameter_names: ClassVar[tuple[str, ...]] = ("clips",)

    num_fixtures: int = 2
    cable: CableKind = "default"
    goals: Goals = "routed"

    def __post_init__(self) -> None:
        """Refuse values that no scene can be drawn for."""
        check_integer("num_fixtures", self.num_fixtures, 1, MOST_FIXTURES)
        check_choice("cable", self.cable, tuple(CABLES))
        check_choice("goals", self.goals, ("routed", "contact"))

    @property
    def max_steps(self) -> int:
        """Budget: 300 control steps for one or two clips, 200 more for each further one."""
        return MAX_STEPS + EXTRA_STEPS * max(0, self.num_fixtures - 2)

    @property
    def ends_on_success(self) -> bool:
        """Not with contact goals: on the way through two throats, "only the first" holds, too."""
        return self.goals == "routed"

    def draw_scenes(self, rng: np.random.Generator) -> Scenes[CableRoutingScene]:
        """Clips at random places; see ``icd_envs.scenes.cable_routing``."""
        scene = draw_scene(rng, self.num_fixtures, cable_for(self.cable, self.num_fixtures))
        if self.goals == "contact":
            scene = replace(scene, contacts=draw_contacts(rng, self.num_fixtures))
        return Scenes(scene, scene)

    def make_plant(self, scene: CableRoutingScene) -> Plant:
        """Cable straight and almost taut, pointing away from the clips, held at the far end."""
        links = scene.cable.links
        where = np.linspace(0.0, links, CLOUD_POINTS)
        start = np.minimum(where.astype(np.int64), links - 1)
        cloud = TrackedCloud(start, (where - start)[:, None])
        plant = Plant(scene_xml(scene), cloud, self.action_scale)
        outward = np.array([np.cos(scene.start_bearing), np.sin(scene.start_bearing), 0.0])
        plant.data.qpos[plant.gripper_qpos] = scene.anchor + scene.cable.length * outward
        motion = (RISE * np.array([0.0, 0.0, 1.0]) - SLACK * outward) / SETTLE_STEPS[0]
        for _ in range(SETTLE_STEPS[0]):
            plant.step(motion / self.action_scale)
        for _ in range(SETTLE_STEPS[1]):
            plant.step(np.zeros(3))
        return plant

    def boxes(self, scene: CableRoutingScene) -> list[Box]:
        """Walls, lips and base plates of the clips."""
        return scene.boxes()

    def make_expert(
        self,
        scene: CableRoutingScene,
        rng: np.random.Generator | None = None,
        *,
        noisy: bool = False,
    ) -> CableRoutingExpert:
        """Clean, or with a style drawn from ``rng``."""
        style = draw_style(rng, scene.contacts) if noisy and rng is not None else None
        return CableRoutingExpert(scene, self.action_scale, style, rng)

    def parameters(self, scene: CableRoutingScene) -> dict[str, Float64Array]:
        """``clips``: (F, 3) position x, y [m] and yaw [rad] of each clip."""
        return {"clips": scene.clip_poses}

    def solved(self, points: Float32Array, scene: CableRoutingScene) -> BoolArray:
        """(F,) which clips the cable passes as the scene asks for."""
        return np.array([_passes_as(points, scene, i) for i in range(len(scene.clips))])

    def matches(
        self, achieved: FloatArray, desired: FloatArray, info: Mapping[str, Any]
    ) -> BoolArray:
        """(B, F) clips that both pass as often and in the same sense, each in its own scene."""
        found = signed_crossings(achieved, info["clips"])
        return found == signed_crossings(desired, info["goal_clips"])

    def canonical_cloud(self) -> Float32Array:
        """(200, 3) straight cable along x from the origin."""
        cloud = np.zeros((CLOUD_POINTS, 3), dtype=np.float32)
        length = cable_for(self.cable, self.num_fixtures).length
        cloud[:, 0] = np.linspace(0.0, length, CLOUD_POINTS)
        return cloud


def _passes_as(points: Float32Array, scene: CableRoutingScene, i: int) -> bool:
    clip = scene.clips[i]
    through = find_crossing(points, clip) is not None
    match scene.contacts[i]:
        case "through":
            return through
        case "behind":
            return not through and passes_behind(points, clip)
        case "free":
            gap = float(BoxUnion(clip.boxes())(points).min()) - scene.cable.radius
            return gap > UNTOUCHED


@dataclass(frozen=True)
class CableRoutingAdaptation(CableRouting):
    """The task behind ``ICDCableRoutingAdaptation-v0``: the goal is of another scene."""

    env_id: ClassVar[str] = "ICDCableRoutingAdaptation-v0"

    def draw_scenes(self, rng: np.random.Generator) -> Scenes[CableRoutingScene]:
        """The goal's scene as in cable routing, and one in which every clip stands elsewhere."""
        while True:
            goal_scene = super().draw_scenes(rng).scene
            scene = perturb(goal_scene, rng)
            if scene is not None:
                return Scenes(scene, goal_scene)


class CableRoutingEnv(ContactEnv[CableRoutingScene]):
    """Route a cable through randomly placed clips.

    One end of the cable is fixed, the other is held by a floating gripper. The goal is a pair of
    clouds, cable and scene; success is not to match it point by point but to pass every clip's
    throat as the goal does.

    Observation: ``icd_envs.api.Observation``; the object cloud runs along the cable's centre line
    from the fixed end to the held one.

    Action: translation of the gripper along the axes of the world's frame, in which clouds are
    observed too (z up, the floor at 0), in units of 0.03 m per control step of 0.05 s.

    Reward: ``sparse``: 0 on success, else -1. ``dense``: complete rate - 1 - mean distance [m]
    between corresponding points of object and goal.

    Success: every clip is passed as often, and in the same sense, as the goal passes it; the
    complete rate is the share of such clips.

    End of episode: ``terminated`` once success has held for 10 steps, or if the physics diverged;
    truncated after 300 steps, 500 with three clips, 700 with four. With ``goals="contact"`` success
    does not end it: what holds at its last step counts.

    Version history:
        v0: first.
    """

    task_class: ClassVar[type[CableRouting]] = CableRouting

    def __init__(
        self,
        *,
        num_fixtures: int = 2,
        cable: CableKind = "default",
        goals: Goals = "routed",
        split: Split = "train",
        reward_type: RewardType = "sparse",
        obs_mode: ObservationMode = "full",
        render_mode: str | None = None,
        width: int = 480,
        height: int = 360,
        camera: str = "overview",
    ) -> None:
        """Set the environment up; nothing is built before the first reset.

        Args:
            num_fixtures: clips to route through, 1 to 4.
            cable: ``default``, ``charging`` (soft, thin), ``ethernet`` (stiff) or ``rope`` (thick).
            goals: ``routed``: through every clip. ``contact``: for every clip one of through,
                behind (along its back) and free (untouched) is drawn, at least one of them
                through; the goal is reached when the cable passes the throats that it passes in
                the goal, and no other.
            split: which scenes to draw; train and test never share one.
            reward_type: ``sparse`` or ``dense``.
            obs_mode: ``full``, or ``partial``: what one camera sees of object and scene, with
                noise; see ``icd_envs.api.PartialObservation``.
            render_mode: None, ``human``, ``rgb_array`` or ``depth_array``.
            width: [px] of rendered pictures.
            height: [px] of rendered pictures.
            camera: ``overview``, ``side`` or ``top``.

        Raises:
            InvalidOptionError: on a value that an option cannot take.
        """
        super().__init__(
            self.task_class(num_fixtures, cable, goals), split=split, reward_type=reward_type,
            obs_mode=obs_mode, render_mode=render_mode, width=width, height=height, camera=camera,
        )  # fmt: skip


class CableRoutingAdaptationEnv(CableRoutingEnv):
    """Cable routing with a goal that was specified in another scene (paper, adaptation test).

    Goal and ``goal_scene`` belong together; in the present scene every clip is moved by 8 to 18 cm,
    at least 8 of them out of or against its mouth, and turned by 10 to 40 degrees. The goal is
    reached when the cable passes every clip as it does there, wherever that is now. All else is as
    in ``ICDCableRouting-v0``; note that the dense reward's distance is to a cloud in the wrong
    place.

    Version history:
        v0: first.
    """

    task_class = CableRoutingAdaptation


make_cable_routing: Final = EnvFactory(CableRoutingEnv)
make_cable_routing_adaptation: Final = EnvFactory(CableRoutingAdaptationEnv)
