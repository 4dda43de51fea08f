"""What is drawn on top of a scene: the goal in red, an agent's plan in blue.

The object itself is yellow. Colours are shared by pictures, the desktop window and the browser.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from icd_envs.api import Float32Array, Float64Array, FloatArray, PlanView

if TYPE_CHECKING:
    import mujoco

Rgba = tuple[float, float, float, float]

OBJECT_RGBA: Final[Rgba] = (0.95, 0.8, 0.1, 1.0)
GOAL_RGBA: Final[Rgba] = (0.85, 0.1, 0.1, 1.0)
CURRENT_RGBA: Final[Rgba] = (0.1, 0.35, 0.95, 0.6)
"""Of the next subgoal."""
GHOST_RGBA: Final[Rgba] = (0.1, 0.35, 0.95, 0.15)
"""Of the subgoals after it."""
PATH_RGBA: Final[Rgba] = (0.1, 0.6, 0.75, 0.8)
"""Of the futures that a planner considered."""

GOAL_RADIUS: Final = 0.004
"""[m] of the spheres that show the goal."""
GHOST_RADIUS: Final = 0.005
"""[m] of those that show a subgoal."""
GHOST_EVERY: Final = 3
"""One of so many points of a subgoal is drawn: a dotted ghost hides nothing."""
PATH_RADIUS: Final = 0.001
"""[m] of the lines that show futures."""


def ghosts(plan: PlanView, goal: FloatArray) -> list[tuple[FloatArray, Rgba]]:
    """Clouds of the subgoals still ahead, nearest first, each with its colour.

    Args:
        plan: of an agent.
        goal: (N, 3) [m]; a subgoal that is the goal itself is drawn as the goal already.
    """
    if plan.subgoals is None:
        return []
    ahead = plan.subgoals[plan.subgoal :]
    return [
        (cloud, GHOST_RGBA if place else CURRENT_RGBA)
        for place, cloud in enumerate(ahead)
        if not np.array_equal(cloud, goal)
    ]


@dataclass(frozen=True)
class Overlay:
    """What is drawn on top of one scene.

    Attributes:
        goal: (N, 3) [m], or (0, 3).
        plan: of an agent, if it has one.
    """

    goal: Float32Array
    plan: PlanView | None = None

    def add_to(self, scene: mujoco.MjvScene) -> None:
        """Append to a scene that MuJoCo is about to draw; what finds no room is left out."""
        _add_points(scene, self.goal, GOAL_RADIUS, GOAL_RGBA)
        if self.plan is None:
            return
        for cloud, rgba in ghosts(self.plan, self.goal):
            _add_points(scene, cloud[::GHOST_EVERY], GHOST_RADIUS, rgba)
        if self.plan.paths is not None:
            for path in self.plan.paths:
                _add_path(scene, path)


def _add_points(scene: mujoco.MjvScene, points: FloatArray, radius: float, rgba: Rgba) -> None:
    for point in points[: scene.maxgeom - scene.ngeom]:
        _add_geom(scene, rgba, np.full(3, radius), point.astype(float))


def _add_path(scene: mujoco.MjvScene, path: FloatArray) -> None:
    import mujoco

    room = scene.maxgeom - scene.ngeom
    for start, end in pairwise(path[: room + 1].astype(float)):
        geom = _add_geom(scene, PATH_RGBA, np.zeros(3), start)
        mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, PATH_RADIUS, start, end)


def _add_geom(
    scene: mujoco.MjvScene, rgba: Rgba, size: Float64Array, position: Float64Array
) -> mujoco.MjvGeom:
    """A sphere; what is translucent casts no shadow."""
    import mujoco

    geom = scene.geoms[scene.ngeom]
    colour = np.array(rgba, dtype=np.float32)
    mujoco.mjv_initGeom(
        geom, mujoco.mjtGeom.mjGEOM_SPHERE, size, position, np.eye(3).ravel(), colour
    )
    # Both keep what an earlier picture left there, unless they are set.
    ghostly = rgba[3] < 1.0
    kind = mujoco.mjtCatBit
    geom.category = kind.mjCAT_DECOR if ghostly else kind.mjCAT_DYNAMIC
    geom.transparent = ghostly
    scene.ngeom += 1
    return geom
