"""Scripted expert for notebook folding.

It lifts the notebook until it hangs free, carries it along a lane without obstacles over the
table's edge, lets the free edge touch down and lays the rest down while it moves on, lifts the
held edge in an arc about the spine, and presses. It looks at the notebook at every step: where
the free edge and the spine really are decides where to go next.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from icd_envs.api import Float64Array, FloatArray
from icd_envs.geometry.folding import COLUMNS, ROWS
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.notebook_folding import NotebookFoldingScene

Fault = Literal["beside", "open"]
Phase = Literal["detour", "lift", "aside", "carry", "lay", "fold", "press"]

PHASES: Final[tuple[Phase, ...]] = ("detour", "lift", "aside", "carry", "lay", "fold", "press")

GAP: Final = 0.02
"""[m] between the hanging notebook and what it is carried over."""
CLEARANCE: Final = 0.015
"""[m] between the swept space and obstacles that a way must keep."""
HEAD: Final = 0.12
"""[m] height of the hand above the point it holds."""
HEIGHTS: Final = 6
LANES: Final = 13
"""Number of heights and lanes that are compared."""
LANE_EDGE: Final = 0.02
"""[m] of table left beside a notebook."""
PITCH: Final = 0.02
"""[m] spacing of the points that stand for the swept space."""
SLACK: Final = 0.8
"""Radius of the arc on which it is laid down, as a share of the length: a taut one would slip."""
LAID: Final = 0.98
"""Distance of the held edge from where the free one touched down, as a share of the length."""
TOUCH: Final = 0.01
"""[m] height of the held edge above the surface when the notebook has been laid down."""
PRESS: Final = 0.014
"""[m] height of the held edge above the surface when the notebook is folded."""
ADVANCE: Final = 0.35
"""[rad] by which the target of an arc runs ahead of the gripper."""
ARRIVED: Final = 0.015
"""[m]"""
TRAILING: Final = -0.01
"""[m] the free edge must be this far behind the gripper before it is lowered."""
TAIL: Final = 0.08
"""[m] by which it is behind when it touches down."""
WAIT_STEPS: Final = 25
"""Control steps after which it is lowered all the same."""
STALL_STEPS: Final = 8
STALL_TRAVEL: Final = 0.02
"""[m] a gripper that moves less than this in STALL_STEPS is blocked, which ends a phase."""


@dataclass(frozen=True)
class Style:
    """How an expert behaves in one episode; the default is a clean demonstration.

    Attributes:
        fault: lay the notebook down beside the table, or leave it open; None is neither.
        speed: [m] gripper translation per control step.
        noise: [m] standard deviation per axis of Gaussian noise on each translation.
        detour: (3,) [m] a place to visit first, or None.
    """

    fault: Fault | None = None
    speed: float = 0.028
    noise: float = 0.0
    detour: tuple[float, float, float] | None = None


def draw_style(rng: np.random.Generator) -> Style:
    """Behaviour for data that is not all good demonstrations (paper: it need not be).

    With probability 0.3 one of: laid down beside the table, left open, a detour.

    Args:
        rng: source of every draw.
    """
    fault: Fault | None = None
    detour = None
    if rng.random() < 0.3:
        match int(rng.integers(3)):
            case 0:
                fault = "beside"
            case 1:
                fault = "open"
            case _:
                x, y, z = rng.uniform((-0.4, -0.4, 0.1), (0.2, 0.4, 0.6))
                detour = (float(x), float(y), float(z))
    return Style(fault, rng.uniform(0.018, 0.03), rng.uniform(0.0, 0.01), detour)


class Way(NamedTuple):
    """Where the notebook is carried.

    Attributes:
        height: [m] of the gripper.
        start: [m] x at which it changes lanes.
        lane: [m] y of the lane.
        touch: [m] x at which the free edge touches down.
        ground: [m] height of what it is laid on.
    """

    height: float
    start: float
    lane: float
    touch: float
    ground: float


def find_way(scene: NotebookFoldingScene) -> Way:
    """The shortest of the ways that keep clear of obstacles; else the one that comes closest."""
    table, notebook = scene.table, scene.notebook
    low = table.height + notebook.length + GAP
    clear = BoxUnion(scene.obstacles)
    room = max(0.0, table.half[1] - notebook.width / 2 - LANE_EDGE)
    touch = table.position[0] - notebook.length / 2 + TAIL
    ways = [
        Way(height, 0.0, lane, touch, table.height)
        for height in low + np.linspace(0.0, 0.15, HEIGHTS)
        for lane in table.position[1] + room * np.linspace(-1.0, 1.0, LANES)
    ]
    costs = []
    for way in ways:
        gap = float(clear(_swept(scene, way)).min())
        missing = max(0.0, CLEARANCE - gap)
        off = abs(way.lane - table.position[1])
        costs.append(100 * missing + way.height + abs(way.lane) + 0.2 * off)
    return ways[int(np.argmin(costs))]


def _swept(scene: NotebookFoldingScene, way: Way) -> Float64Array:
    """(M, 3) [m] points of the space that notebook and hand pass through."""
    spec = scene.notebook
    side = spec.width / 2
    hem = way.height - spec.length
    top = way.height + HEAD
    sides = (min(0.0, way.lane) - side, max(0.0, way.lane) + side)
    spaces = [
        ((-0.03, -side, 0.02), (0.03, side, top)),
        ((way.start - 0.06, sides[0], hem), (way.start + 0.03, sides[1], top)),
        ((way.start, way.lane - side, hem), (way.touch + 0.03, way.lane + side, top)),
        (
            (way.touch - TAIL - 0.03, way.lane - side, way.ground + 0.01),
            (way.touch + spec.length, way.lane + side, way.height),
        ),
    ]
    return np.concatenate([_lattice(*space) for space in spaces])


def _lattice(low: tuple[float, float, float], high: tuple[float, float, float]) -> Float64Array:
    axes = [np.arange(a, b + PITCH, PITCH) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


class NotebookFoldingExpert:
    """Closed-loop expert with access to the scene's geometry."""

    def __init__(
        self,
        scene: NotebookFoldingScene,
        action_scale: float,
        style: Style | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Prepare for one episode.

        Args:
            scene: where to fold.
            action_scale: [m] translation for an action of 1.
            style: behaviour; None is a clean demonstration.
            rng: source of the action noise; needed if ``style.noise`` is positive.
        """
        self._scene = scene
        self._scale = action_scale
        self._style = style or Style()
        self._rng = rng
        self._way = find_way(scene)
        if self._style.fault == "beside":
            self._way = _beside(scene, self._way)
        self._phase = 0 if self._style.detour else 1
        self._waited = 0
        self._hem = -np.inf
        self._spine = 0.0
        self._recent: deque[Float64Array] = deque(maxlen=STALL_STEPS)

    @property
    def done(self) -> bool:
        """Never: it holds the cover down for as long as it may."""
        return False

    def act(self, gripper: FloatArray, points: FloatArray) -> Float64Array:
        """Next action.

        Args:
            gripper: (3,) [m] position.
            points: (N, 3) [m] object cloud, column by column from the held edge.

        Returns:
            (3,) in [-1, 1].
        """
        place = np.asarray(gripper, float)
        columns = np.asarray(points, float).reshape(COLUMNS, ROWS, 3).mean(axis=1)
        if PHASES[self._phase] not in ("fold", "press"):
            self._spine = float(columns[COLUMNS // 2 - 1 : COLUMNS // 2 + 1, 0].mean())
        target = self._target(place, columns)
        self._recent.append(place)
        while self._finished(place, columns, target):
            self._phase += 1
            self._recent.clear()
            target = self._target(place, columns)
        error = target - place
        step = error * min(1.0, self._style.speed / max(float(np.linalg.norm(error)), 1e-9))
        if self._style.noise > 0 and self._rng is not None:
            step = step + self._rng.normal(0.0, self._style.noise, 3)
        return np.clip(step / self._scale, -1.0, 1.0)

    def _finished(self, place: Float64Array, columns: Float64Array, target: Float64Array) -> bool:
        last = "lay" if self._style.fault == "open" else "press"
        if PHASES[self._phase] == last:
            return False
        if PHASES[self._phase] == "carry" and self._waited < WAIT_STEPS:
            return self._trails(place, columns, target)
        stalled = (
            len(self._recent) == STALL_STEPS
            and float(np.linalg.norm(self._recent[-1] - self._recent[0])) < STALL_TRAVEL
        )
        return stalled or float(np.linalg.norm(target - place)) < ARRIVED

    def _trails(self, place: Float64Array, columns: Float64Array, target: Float64Array) -> bool:
        """Whether the gripper has arrived and the free edge swings back below or behind it."""
        if float(np.linalg.norm(target - place)) >= ARRIVED + self._style.noise:
            return False
        self._waited += 1
        hem, self._hem = self._hem, float(columns[-1, 0])
        return self._hem < min(hem, place[0] + TRAILING)

    def _target(self, place: Float64Array, columns: Float64Array) -> Float64Array:
        """(3,) [m] where the present phase moves the gripper."""
        way, spec = self._way, self._scene.notebook
        folded = np.array([self._spine - spec.cover, way.lane, way.ground + PRESS])
        match PHASES[self._phase]:
            case "detour":
                return np.array(self._style.detour or place)
            case "lift":
                return np.array([way.start, place[1], way.height])
            case "aside":
                return np.array([way.start, way.lane, way.height])
            case "carry":
                return np.array([way.touch, way.lane, way.height])
            case "lay":
                pivot = np.array([columns[-1, 0], way.lane, way.ground])
                flat = pivot + np.array([LAID * spec.length, 0.0, TOUCH])
                return _along_arc(place, pivot, SLACK * spec.length, flat, -1.0)
            case "fold":
                pivot = np.array([self._spine, way.lane, way.ground])
                return _along_arc(place, pivot, spec.cover, folded, 1.0)
            case "press":
                return folded


def _beside(scene: NotebookFoldingScene, way: Way) -> Way:
    """On the floor next to the table, on the side away from the lane's obstacles."""
    table = scene.table
    side = 1.0 if way.lane >= table.position[1] else -1.0
    lane = table.position[1] + side * (table.half[1] + scene.notebook.width / 2 + 0.06)
    return way._replace(lane=lane, ground=0.0)


def _along_arc(
    place: Float64Array, pivot: Float64Array, radius: float, end: Float64Array, turn: float
) -> Float64Array:
    """(3,) [m] point ahead on a vertical arc, or its end once that is near.

    Args:
        place: (3,) [m] gripper.
        pivot: (3,) [m] centre of the arc.
        radius: [m]
        end: (3,) [m] where the arc ends.
        turn: +1 from +x up and over to -x, -1 the other way.
    """
    ahead = end - place
    arm = place - pivot
    angle = np.arctan2(arm[2], arm[0]) + turn * ADVANCE
    over = angle > np.pi if turn > 0 else angle < 0
    if over or float(np.hypot(ahead[0], ahead[2])) < ADVANCE * radius:
        return end
    return pivot + radius * np.array([np.cos(angle), 0.0, np.sin(angle)])
