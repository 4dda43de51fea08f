"""The three-dimensional part of the browser's view: clouds, meshes, subgoals and futures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.watch.session import Moment
from icd_envs.api import FloatArray
from icd_envs.drawing import (
    CURRENT_RGBA,
    GHOST_EVERY,
    GHOST_RGBA,
    GOAL_RGBA,
    OBJECT_RGBA,
    PATH_RGBA,
    Rgba,
    ghosts,
)
from icd_envs.meshes import Mesh, group_meshes
from icd_envs.scenes import layers
from icd_envs.tasks.env import ContactEnv

if TYPE_CHECKING:
    import viser

PARTS: Final = {
    "object": True,
    "goal": True,
    "fixtures": True,
    "hand": True,
    "subgoals": True,
    "plan": True,
    "best samples": True,
    "their ends": False,
    "scene cloud": False,
    "goal's scene": False,
}
"""What can be shown, and whether it is at first."""

SCENE_RGBA: Final[Rgba] = (0.2, 0.22, 0.25, 1.0)
PLAN_RGBA: Final[Rgba] = (0.05, 0.65, 0.35, 1.0)
FLOOR_RGB: Final = (122, 133, 145)
LINE_RGB: Final = (104, 115, 127)
POINT_SIZE: Final = 0.008
"""[m] of the points of object and goal."""
SMALL_POINT_SIZE: Final = 0.003
"""[m] of all others."""
GHOSTS: Final[dict[Rgba, tuple[Rgba, float]]] = {
    CURRENT_RGBA: (CURRENT_RGBA, 0.006),
    GHOST_RGBA: ((0.36, 0.47, 0.66, 1.0), 0.004),
}
"""Colour and size [m] of subgoals' points: viser's are not translucent, so later ones are grey."""


class BrowserScene:
    """Draws moments of one scene after another into a viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Begin with the floor alone."""
        self._server = server
        self._scene = server.scene
        self._visible = dict(PARTS)
        self._frames: dict[str, viser.FrameHandle] = {}
        self._subgoal: tuple[int, int] | None = None
        self._scene.configure_default_lights(cast_shadow=False)  # clouds cast none either
        self._scene.add_grid(
            "/floor", 4.0, 4.0, cell_size=0.25, section_size=0.25, cell_color=LINE_RGB,
            section_color=LINE_RGB, plane_color=FLOOR_RGB, plane_opacity=1.0,
        )  # fmt: skip

    def set_visible(self, part: str, visible: bool) -> None:
        """Show or hide one of ``PARTS``."""
        self._visible[part] = visible
        if part in self._frames:
            self._frames[part].visible = visible

    def begin(self, env: ContactEnv[Any], moment: Moment) -> None:
        """Replace the scene by another one."""
        for frame in self._frames.values():
            frame.remove()
        self._frames = {
            part: self._scene.add_frame(f"/{part}", show_axes=False, visible=self._visible[part])
            for part in PARTS
        }
        self._subgoal = None
        for mesh in group_meshes(env.model, env.data, layers.FIXTURE["group"]):
            self._add_mesh("fixtures", mesh, mesh.position)
        gripper = moment.observation["observation"][:3]
        for mesh in group_meshes(env.model, env.data, layers.GRIPPER["group"]):
            self._add_mesh("hand", mesh, mesh.position - gripper)
        observation = moment.observation
        self._add_points("goal", "cloud", observation["desired_goal"], GOAL_RGBA)
        self._add_points("scene cloud", "cloud", observation["scene"], SCENE_RGBA, SMALL_POINT_SIZE)
        self._add_points(
            "goal's scene", "cloud", observation["goal_scene"], GOAL_RGBA, SMALL_POINT_SIZE
        )
        self.draw(moment)

    def draw(self, moment: Moment) -> None:
        """Draw what changes from moment to moment."""
        with self._server.atomic():
            observation = moment.observation
            self._frames["hand"].position = observation["observation"][:3].astype(float)
            self._add_points("object", "cloud", observation["achieved_goal"], OBJECT_RGBA)
            self._draw_subgoals(moment)
            plan, future = moment.plan, moment.future
            ends = plan.ends if plan is not None and plan.ends is not None else np.empty((0, 0, 3))
            self._add_points(
                "their ends", "clouds", ends.reshape(-1, 3), PATH_RGBA, SMALL_POINT_SIZE
            )
            paths = (
                plan.paths if plan is not None and plan.paths is not None else np.empty((0,) * 3)
            )
            self._add_paths("best samples", paths, PATH_RGBA, 0.0015)
            cloud = np.empty((0, 3)) if future is None else future.end
            self._add_points("plan", "end", cloud, PLAN_RGBA, SMALL_POINT_SIZE)
            path = np.empty((0, 0, 3)) if future is None else future.path[None]
            self._add_paths("plan", path, PLAN_RGBA, 0.004)

    def _draw_subgoals(self, moment: Moment) -> None:
        plan = moment.plan
        key = None if plan is None or plan.subgoals is None else (id(plan.subgoals), plan.subgoal)
        if key == self._subgoal:
            return
        self._subgoal = key
        clouds = [] if plan is None else ghosts(plan, moment.observation["desired_goal"])
        for name, rgba in (("next", CURRENT_RGBA), ("later", GHOST_RGBA)):
            chosen = [cloud[::GHOST_EVERY] for cloud, colour in clouds if colour == rgba]
            points = np.concatenate([np.empty((0, 3)), *chosen])
            self._add_points("subgoals", name, points, *GHOSTS[rgba])

    def _add_points(
        self, part: str, name: str, points: FloatArray, rgba: Rgba, size: float = POINT_SIZE
    ) -> None:
        self._scene.add_point_cloud(
            f"/{part}/{name}", points.astype(np.float32), _rgb(rgba), point_size=size,
            point_shape="circle", precision="float32",
        )  # fmt: skip

    def _add_paths(self, part: str, paths: FloatArray, rgba: Rgba, thickness: float) -> None:
        segments = np.stack([paths[:, :-1], paths[:, 1:]], axis=2).reshape(-1, 2, 3)
        self._scene.add_line_segments(
            f"/{part}/paths", segments.astype(np.float32), _rgb(rgba), thickness=thickness
        )

    def _add_mesh(self, part: str, mesh: Mesh, position: FloatArray) -> None:
        from viser.transforms import SO3

        self._scene.add_mesh_simple(
            f"/{part}/{mesh.name}", mesh.vertices, mesh.faces, color=_rgb(tuple(mesh.rgba)),
            flat_shading=True, position=position, wxyz=SO3.from_matrix(mesh.rotation).wxyz,
        )  # fmt: skip


def _rgb(rgba: Rgba) -> NDArray[np.uint8]:
    return (255 * np.array(rgba[:3])).round().astype(np.uint8)
