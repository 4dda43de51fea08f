"""Scripted expert for cable routing.

The taut cable is an arm that turns about a pivot: first the anchor, then the last routed clip.
For every clip in order the gripper lifts the arm, swings it over the clip to its mouth's side,
lowers it to the floor and sweeps it back into the throat. It looks at the cable at every step:
a clip that was missed or lost is tried again.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from icd_envs.api import Float64Array, FloatArray
from icd_envs.geometry.routing import Crossing, find_crossing
from icd_envs.scenes.cable_routing import CableRoutingScene, Contact

Phase = Literal["detour", "lift", "swing", "lower", "sweep"]

PHASES: Final[tuple[Phase, ...]] = ("detour", "lift", "swing", "lower", "sweep")

CLEARANCE_SIDE: Final = 0.115
"""[m] the arm passes this far beside the throat's centre before it is lowered."""
CLEARANCE_TOP: Final = 0.16
"""[m] height of the arm above the clip it is lifted over; a clip is 0.09 m tall."""
SWEEP: Final = 0.14
"""[m] how far past the throat's centre the arm sweeps, against the clip's wall."""
SEATED: Final = 0.005
"""[m] a cable deeper in the throat than this, in the clip's x, needs no further sweep."""
SLACK: Final = 0.015
"""[m^2] over the squared length of the cable: by which share of the free length the gripper stays
short of taut. A slack arm hangs in a bow whose depth goes with the length times the root of that
share; it must stay below the clearances, however long the cable is."""
LOW: Final = 0.02
"""[m] lowest height of the gripper."""
ARRIVED: Final = 0.03
"""[rad]"""
STRAY_BEGINS: Final = 150
"""Strays begin before this control step."""
STRAY_STEPS: Final = (10, 31)
STRAY_SPEED: Final = (0.015, 0.03)
"""[m] per control step."""
STALL_STEPS: Final = 10
STALL_TRAVEL: Final = 0.02
"""[m] a gripper that moves less than this in STALL_STEPS is blocked, which ends a phase."""


class Stray(NamedTuple):
    """The gripper is led astray for a while, then the expert begins the present clip anew.

    Attributes:
        begin: control step of the episode.
        end: first step on which the expert acts again.
        velocity: (3,) [m] translation per control step in between.
    """

    begin: int
    end: int
    velocity: Float64Array


@dataclass(frozen=True)
class Style:
    """How an expert behaves in one episode; the default is a clean demonstration.

    Attributes:
        contacts: what to do at each clip; None is what the scene asks for.
        speed: [m] gripper translation per control step.
        noise: [m] standard deviation per axis of Gaussian noise on each translation.
        detour: (2,) bearing and elevation [rad] of a place to visit first, or None.
        strays: times at which the gripper is led elsewhere.
    """

    contacts: tuple[Contact, ...] | None = None
    speed: float = 0.028
    noise: float = 0.0
    detour: tuple[float, float] | None = None
    strays: tuple[Stray, ...] = ()


def draw_style(rng: np.random.Generator, wanted: tuple[Contact, ...]) -> Style:
    """Behaviour for data that is not all good demonstrations (paper: it need not be).

    With probability 0.3 one of: a clip passed behind, a clip left alone, a detour. With
    probability 0.5 the gripper is led astray once or twice, so that there are slack cables, missed
    clips and ways out of both.

    Args:
        rng: source of every draw.
        wanted: what the scene asks for at each clip.
    """
    contacts = list(wanted)
    detour = None
    if rng.random() < 0.3:
        fault = rng.integers(3)
        if fault == 2:
            detour = (rng.uniform(-np.pi, np.pi), rng.uniform(0.0, 0.6))
        else:
            contacts[rng.integers(len(wanted))] = "behind" if fault == 0 else "free"
    speed, noise = rng.uniform(0.018, 0.03), rng.uniform(0.0, 0.01)
    strays = [_draw_stray(rng) for _ in range(rng.integers(1, 3))] if rng.random() < 0.5 else []
    return Style(tuple(contacts), speed, noise, detour, tuple(strays))


def _draw_stray(rng: np.random.Generator) -> Stray:
    begin, duration = rng.integers(STRAY_BEGINS), rng.integers(*STRAY_STEPS)
    direction = rng.normal(size=3)
    speed = rng.uniform(*STRAY_SPEED)
    return Stray(int(begin), int(begin + duration), speed * direction / np.linalg.norm(direction))


class CableRoutingExpert:
    """Closed-loop expert with access to the scene's geometry."""

    def __init__(
        self,
        scene: CableRoutingScene,
        action_scale: float,
        style: Style | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Prepare for one episode.

        Args:
            scene: where to route.
            action_scale: [m] translation for an action of 1.
            style: behaviour; None is a clean demonstration.
            rng: source of the action noise; needed if ``style.noise`` is positive.
        """
        self._scene = scene
        self._scale = action_scale
        self._style = style or Style()
        self._rng = rng
        self._contacts = self._style.contacts or scene.contacts
        self._passed = [False] * len(scene.clips)
        self._clip: int | None = None
        self._phase = 0
        self._detoured = self._style.detour is None
        self._recent: deque[Float64Array] = deque(maxlen=STALL_STEPS)
        self._step = 0
        self._done = False

    @property
    def done(self) -> bool:
        """Whether every clip was dealt with at the last ``act``."""
        return self._done

    def act(self, gripper: FloatArray, points: FloatArray) -> Float64Array:
        """Next action.

        Args:
            gripper: (3,) [m] position.
            points: (N, 3) [m] object cloud, from the anchored end to the held one.

        Returns:
            (3,) in [-1, 1]; zero when every clip is done.
        """
        crossings = [find_crossing(points, clip) for clip in self._scene.clips]
        clip = self._next_clip(crossings)
        if clip != self._clip:
            self._clip = clip
            self._begin(0 if not self._detoured else 1)
        stray = self._stray()
        self._step += 1
        self._done = clip is None and stray is None
        translation = np.zeros(3)
        if stray is not None:
            translation = stray.velocity
            self._begin(1)
        elif clip is not None:
            translation = self._move(clip, np.asarray(gripper, float), points, crossings)
        if self._style.noise > 0 and self._rng is not None:
            translation = translation + self._rng.normal(0.0, self._style.noise, 3)
        return np.clip(translation / self._scale, -1.0, 1.0)

    def _stray(self) -> Stray | None:
        now = [each for each in self._style.strays if each.begin <= self._step < each.end]
        return now[0] if now else None

    def _next_clip(self, crossings: list[Crossing | None]) -> int | None:
        for i, (contact, crossing) in enumerate(zip(self._contacts, crossings, strict=True)):
            if contact == "through":
                self._passed[i] = crossing is not None and (
                    self._passed[i] or crossing.depth < SEATED
                )
            if contact != "free" and not self._passed[i]:
                return i
        return None

    def _begin(self, phase: int) -> None:
        self._phase = phase
        self._recent.clear()

    def _move(
        self,
        index: int,
        gripper: Float64Array,
        points: FloatArray,
        crossings: list[Crossing | None],
    ) -> Float64Array:
        pivot, length = self._scene.anchor, self._scene.cable.length
        for crossing in crossings[:index]:
            if crossing is not None:
                share = crossing.segment / (len(points) - 1)
                pivot = points[crossing.segment].astype(np.float64)
                length = self._scene.cable.length * (1 - share)
        radius = (1.0 - SLACK / self._scene.cable.length**2) * length
        arm = gripper - pivot
        now = np.array([np.arctan2(arm[1], arm[0]), np.arctan2(arm[2], np.hypot(*arm[:2]))])
        error = self._target(index, pivot, radius, now) - now
        error[0] = (error[0] + np.pi) % (2 * np.pi) - np.pi

        self._recent.append(gripper)
        stalled = (
            len(self._recent) == STALL_STEPS
            and float(np.linalg.norm(self._recent[-1] - self._recent[0])) < STALL_TRAVEL
        )
        if stalled or bool(np.all(np.abs(error) < ARRIVED)):
            self._finish_phase(index, crossings[index] is not None)

        turn = self._style.speed / radius
        bearing, elevation = now + error * min(1.0, turn / max(float(np.abs(error).max()), 1e-9))
        target = pivot + radius * np.array(
            [
                np.cos(elevation) * np.cos(bearing),
                np.cos(elevation) * np.sin(bearing),
                np.sin(elevation),
            ]
        )
        target[2] = max(target[2], LOW)
        return target - gripper

    def _target(
        self, index: int, pivot: Float64Array, radius: float, now: Float64Array
    ) -> Float64Array:
        """Bearing and elevation [rad] that the present phase moves the arm to."""
        clip = self._scene.clips[index]
        to = clip.origin - pivot
        distance = float(np.hypot(to[0], to[1]))
        bearing = np.arctan2(to[1], to[0])
        side = np.sign(to[0] * clip.mouth[1] - to[1] * clip.mouth[0])
        if self._contacts[index] == "behind":
            side = -side
        beside = bearing + side * np.arctan2(CLEARANCE_SIDE, distance)
        high = np.arcsin(min(0.7, (CLEARANCE_TOP - pivot[2]) / distance))
        low = np.arcsin((LOW - pivot[2]) / radius)
        match PHASES[self._phase]:
            case "detour":
                return np.array(self._style.detour or now)
            case "lift":
                return np.array([now[0], high])
            case "swing":
                return np.array([beside, high])
            case "lower":
                return np.array([beside, low])
            case "sweep":
                return np.array([bearing - side * np.arctan2(SWEEP, distance), low])

    def _finish_phase(self, index: int, routed: bool) -> None:
        if PHASES[self._phase] == "sweep":
            self._passed[index] = routed or self._contacts[index] == "behind"
            self._begin(1)
        else:
            self._detoured = True
            self._begin(self._phase + 1)
