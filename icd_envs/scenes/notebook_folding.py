"""The notebook folding scene: where table and obstacles stand, and how it is drawn and built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from icd_envs.api import Float64Array
from icd_envs.scenes import layers
from icd_envs.scenes.boxes import Box, rotation_z
from icd_envs.scenes.layers import CONTACT_MARGIN
from icd_envs.scenes.notebook import DEFAULT_NOTEBOOK, NotebookSpec, add_notebook

if TYPE_CHECKING:
    from dm_control import mjcf

WORKSPACE: Final = ((-0.6, -0.8, 0.003), (1.2, 0.8, 0.8))
"""[m] lower and upper limits of the gripper, which starts at the origin."""

TABLE_NEAR: Final = (0.10, 0.20)
"""[m] from the held edge at the start to the table's near side."""
TABLE_Y: Final = (-0.12, 0.12)
"""[m] of the table's centre."""
TABLE_YAW: Final = (-0.12, 0.12)
"""[rad] small: the gripper cannot turn the notebook."""
TABLE_HALF: Final = ((0.23, 0.17), (0.30, 0.25))
"""[m] lower and upper limits of its half extents."""
TABLE_HEIGHT: Final = (0.06, 0.15)
"""[m]"""

HURDLE_HALF: Final = ((0.015, 0.04), (0.03, 0.10))
"""[m] limits of the half extents of the obstacle between notebook and table."""
HURDLE_RISE: Final = (0.02, 0.08)
"""[m] by which it is taller than the table."""
BLOCK_HALF: Final = (0.03, 0.06)
"""[m] limits of the half extents of the other obstacles, which stand or float."""
BLOCK_BESIDE: Final = (0.02, 0.15)
"""[m] gap between them and the lane that is left free."""
BLOCK_BOTTOM: Final = (0.05, 0.25)
"""[m] height of a floating one above the table's top."""
START_REACH: Final = 0.07
"""[m] x up to which everything is free, so that the hand can rise and change lanes."""
LANE_HALF: Final = 0.115
"""[m] half width of that lane: the notebook with room to either side."""

PERTURBED_DISTANCE: Final = (0.20, 0.32)
"""[m] by which the table is moved in a perturbed scene."""
PERTURBED_NEAR: Final = (0.10, 0.40)
PERTURBED_Y: Final = (-0.35, 0.35)
"""[m] as TABLE_NEAR and TABLE_Y, for a perturbed scene."""

TABLE_RGBA: Final = (0.62, 0.64, 0.67, 1.0)
OBSTACLE_RGBA: Final = (0.42, 0.45, 0.5, 1.0)
FRICTION: Final = (0.7, 0.005, 0.0001)

CAMERAS: Final = (
    ("overview", (0.75, -1.0, 0.72), (0.2, 0.0, 0.16)),
    ("side", (0.2, -1.25, 0.3), (0.2, 0.0, 0.2)),
    ("top", (0.2, 0.0, 1.7), (0.2, 0.0001, 0.0)),
)
"""Name, position [m], point looked at [m]."""


@dataclass(frozen=True)
class Table:
    """A solid box standing on the floor.

    Attributes:
        position: (2,) [m] of its centre.
        yaw: [rad].
        half: (2,) [m] half extents along its own axes.
        height: [m] of its top.
    """

    position: tuple[float, float]
    yaw: float
    half: tuple[float, float]
    height: float

    def box(self) -> Box:
        """The table as a solid."""
        center = np.array([*self.position, self.height / 2])
        return Box(center, np.array([*self.half, self.height / 2]), rotation_z(self.yaw))

    @property
    def parameters(self) -> Float64Array:
        """(6,) position x, y [m], yaw [rad], half extents x, y [m], height [m]."""
        return np.array([*self.position, self.yaw, *self.half, self.height])


@dataclass(frozen=True)
class NotebookFoldingScene:
    """One drawn scene; the notebook starts flat on the floor, held at the origin.

    Attributes:
        table: where the notebook belongs.
        obstacles: solid boxes, standing or floating.
        notebook: size and mechanics.
    """

    table: Table
    obstacles: tuple[Box, ...]
    notebook: NotebookSpec = DEFAULT_NOTEBOOK

    def boxes(self) -> list[Box]:
        """Every solid."""
        return [self.table.box(), *self.obstacles]


def draw_scene(rng: np.random.Generator) -> NotebookFoldingScene:
    """A table in front of the notebook, a hurdle before it, one or two obstacles beside the way."""
    return _furnish(_draw_table(rng, TABLE_NEAR, TABLE_Y), rng)


def perturb(scene: NotebookFoldingScene, rng: np.random.Generator) -> NotebookFoldingScene:
    """Another scene, in which the table stands elsewhere and nothing has the same size.

    Tables are drawn until one fits, a few times on average.

    Args:
        scene: what to perturb.
        rng: source of every draw.
    """
    while True:
        table = _draw_table(rng, PERTURBED_NEAR, PERTURBED_Y)
        moved = float(np.hypot(*np.subtract(table.position, scene.table.position)))
        if PERTURBED_DISTANCE[0] <= moved <= PERTURBED_DISTANCE[1]:
            return _furnish(table, rng)


def _draw_table(
    rng: np.random.Generator, near: tuple[float, float], y: tuple[float, float]
) -> Table:
    half = rng.uniform(*TABLE_HALF)
    x = rng.uniform(*near) + half[0]
    return Table(
        (float(x), rng.uniform(*y)),
        rng.uniform(*TABLE_YAW),
        (float(half[0]), float(half[1])),
        rng.uniform(*TABLE_HEIGHT),
    )


def _furnish(table: Table, rng: np.random.Generator) -> NotebookFoldingScene:
    """Obstacles around a table."""
    lane = table.position[1] + rng.uniform(-1, 1) * max(0.0, table.half[1] - LANE_HALF)
    blocks = [_draw_block(rng, table, lane, side) for side in _draw_sides(rng)]
    return NotebookFoldingScene(table, (_draw_hurdle(rng, table, lane), *blocks))


def _draw_sides(rng: np.random.Generator) -> list[float]:
    first = float(rng.choice([-1.0, 1.0]))
    return [first, -first][: rng.integers(1, 3)]


def _draw_hurdle(rng: np.random.Generator, table: Table, lane: float) -> Box:
    half = rng.uniform(*HURDLE_HALF)
    height = table.height + rng.uniform(*HURDLE_RISE)
    near = table.position[0] - table.half[0]
    center = np.array([near - half[0] - 0.02, lane / 2 + rng.uniform(-0.05, 0.05), height / 2])
    return Box(center, np.array([half[0], half[1], height / 2]), np.eye(3))


def _draw_block(rng: np.random.Generator, table: Table, lane: float, side: float) -> Box:
    """An obstacle beside the lane, and maybe in the straight way to it, standing or floating."""
    half = rng.uniform(*BLOCK_HALF, size=3)
    yaw = rng.uniform(-np.pi, np.pi)
    reach = float(np.hypot(half[0], half[1]))
    y = lane + side * (LANE_HALF + reach + rng.uniform(*BLOCK_BESIDE))
    x = max(table.position[0] + rng.uniform(-1, 0.5) * table.half[0], START_REACH + reach)
    bottom = table.height + rng.uniform(*BLOCK_BOTTOM)
    if rng.random() < 0.5:  # standing
        half[2], bottom = (bottom + 2 * half[2]) / 2, 0.0
    return Box(np.array([x, y, bottom + half[2]]), half, rotation_z(yaw))


def build_scene(scene: NotebookFoldingScene) -> mjcf.RootElement:
    """The scene as a PyMJCF model, the notebook flat and held at its edge's middle."""
    from icd_envs.scenes.arena import add_camera, make_arena
    from icd_envs.scenes.gripper import add_gripper

    root = make_arena("notebook_folding")
    _add_box(root, "table", scene.table.box(), TABLE_RGBA)
    for i, box in enumerate(scene.obstacles):
        _add_box(root, f"obstacle_{i}", box, OBSTACLE_RGBA)
    for name, position, look_at in CAMERAS:
        add_camera(root, name, position, look_at)
    add_gripper(root, np.array(WORKSPACE))
    add_notebook(root.find("body", "gripper"), scene.notebook)
    return root


def _add_box(
    root: mjcf.RootElement, name: str, box: Box, rgba: tuple[float, float, float, float]
) -> None:
    root.worldbody.add(
        "geom", name=name, type="box", pos=box.center, size=box.half, rgba=rgba,
        xyaxes=[*box.rotation[:, 0], *box.rotation[:, 1]], friction=FRICTION,
        margin=CONTACT_MARGIN, **layers.FIXTURE,
    )  # fmt: skip
