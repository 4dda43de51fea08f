"""The seams between environments, planners, agents and the benchmark. Imports numpy only.

Letters, everywhere the same: K samples, H horizon, N object points, M scene points, F fixtures.
Lengths are metres, world frame, z up; times are seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Protocol, TypedDict, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from icd_envs.errors import InvalidOptionError

FloatArray = NDArray[np.floating[Any]]
Float32Array = NDArray[np.float32]
Float64Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SEEN_CLOUDS: Final = ("achieved_goal", "scene")
"""Clouds of the present state: those that are seen, perhaps in part and with noise."""


class Observation(TypedDict):
    """What every environment of this project observes; float32, metres, world frame.

    Attributes:
        observation: (6,) gripper position [m] and velocity [m/s].
        achieved_goal: (200, 3) object cloud; point i is always the same material point.
        desired_goal: (200, 3) object cloud at the goal.
        scene: (1000, 3) points on the visible surfaces of the present scene: 800 of what stands
            in it, 200 of the floor around that.
        goal_scene: (1000, 3) the same of the scene that the goal was specified in.
    """

    observation: Float32Array
    achieved_goal: Float32Array
    desired_goal: Float32Array
    scene: Float32Array
    goal_scene: Float32Array


class PartialObservation(Observation):
    """What is observed with ``obs_mode="partial"``: one camera's view, with noise.

    Clouds keep size and order; a point that is not seen is (0, 0, 0). Goals stay full.

    Attributes:
        achieved_goal_mask: (200,) 1 where a point of the object is seen, else 0.
        scene_mask: (1000,) the same of the scene.
    """

    achieved_goal_mask: Float32Array
    scene_mask: Float32Array


class CommonInfo(TypedDict):
    """What ``info`` holds in every environment, after reset and step; a task adds its parameters.

    Attributes:
        is_success: every part of the goal is reached now.
        complete_rate: share of the parts that are reached, in [0, 1]; 0 after a divergence.
        diverged: the physics blew up; the observation is the last good one.
        action_clipped: the action was not in [-1, 1].
        buffer_overflows: how often MuJoCo had no room for a contact since the state was last set.
    """

    is_success: bool
    complete_rate: float
    diverged: bool
    action_clipped: bool
    buffer_overflows: int


@dataclass(frozen=True)
class SimState:
    """The whole state of one environment, enough to continue bit for bit.

    Attributes:
        env_id: the environment it was taken from.
        scene_id: fingerprint of the compiled scene; a state fits no other scene.
        physics: (S,) MuJoCo's integration state (``mjSTATE_INTEGRATION``).
        steps: control steps taken in this episode.
        held: consecutive control steps for which success has held.
    """

    env_id: str
    scene_id: str
    physics: Float64Array
    steps: int = 0
    held: int = 0


@dataclass(frozen=True)
class Rollout:
    """What K action sequences of length H lead to.

    Attributes:
        points: (K, H, N, 3) float32 [m], object cloud after each control step.
        gripper: (K, H, 3) float32 [m], gripper position after each control step.
        diverged: (K,) samples whose physics blew up; their other entries are finite but void.
    """

    points: Float32Array
    gripper: Float32Array
    diverged: BoolArray


@runtime_checkable
class Simulator(Protocol):
    """Dynamics and geometry of the present scene, for planners. Privileged information."""

    def snapshot(self) -> SimState:
        """State of the environment now."""
        ...

    def rollout(self, state: SimState, actions: FloatArray) -> Rollout:
        """Roll K action sequences out from one state, leaving the environment untouched.

        Args:
            state: from ``snapshot``.
            actions: (K, H, 3) in [-1, 1], as for ``env.step``; clipped to that range.
        """
        ...

    def signed_distance(self, points: FloatArray) -> Float64Array:
        """Signed distance to the scene's obstacles, negative inside.

        Args:
            points: (M, 3) [m], world frame.

        Returns:
            (M,) [m].
        """
        ...


@dataclass(frozen=True)
class Oracle:
    """How the scripted expert solved this scene. Privileged: for ceilings and ablations only.

    Attributes:
        scene: the task's own scene description (positions of fixtures and so on).
        points: (T, N, 3) float32 [m], object cloud at the start and after each expert step.
        actions: (T - 1, 3) float32 in [-1, 1], the expert's actions.
    """

    scene: object
    points: Float32Array
    actions: Float32Array


@dataclass(frozen=True)
class Episode:
    """What an agent is told when an episode begins.

    Attributes:
        env_id: id of the environment.
        action_scale: [m] gripper translation per control step for an action of 1.
        control_period: [s] duration of one control step.
        max_steps: control steps before the episode is truncated.
        canonical_cloud: (N, 3) float32 [m], the object in its own rest frame, same point order.
        gripper_spheres: (S, 4) float32, centre relative to the gripper position [m] and radius [m].
        simulator: only for agents with ``needs_simulator = True``.
        oracle: only for agents with ``needs_oracle = True``.
        goal_oracle: likewise; how the expert solved the scene that the goal was specified in. The
            same as ``oracle`` except in the adaptation tasks.
        ends_on_success: whether the episode is over soon after its goal is reached; if not, the
            goal must be kept to the end.
        foreign_goal: whether the goal was specified in another scene than the present one.
    """

    env_id: str
    action_scale: float
    control_period: float
    max_steps: int
    canonical_cloud: Float32Array
    gripper_spheres: Float32Array
    simulator: Simulator | None = None
    oracle: Oracle | None = None
    goal_oracle: Oracle | None = None
    ends_on_success: bool = True
    foreign_goal: bool = False


@dataclass(frozen=True)
class PlanView:
    """What an agent shows of its plan to whoever draws it; nothing is decided by it.

    Every part but the status may be None. Arrays may be the agent's own: do not write into them.

    Attributes:
        status: one line for people.
        subgoals: (L, N, 3) [m] every subgoal as an object cloud.
        subgoal: index of the next one; those before it are done with.
        actions: (H, 3) in [-1, 1], the plan; its first action is the one being executed.
        paths: (B, H, 3) [m] gripper positions of the best futures considered, best first.
        ends: (B, N, 3) [m] object clouds at their ends.

    Raises:
        InvalidOptionError: on arrays of other shapes.
    """

    status: str = ""
    subgoals: FloatArray | None = None
    subgoal: int = 0
    actions: FloatArray | None = None
    paths: FloatArray | None = None
    ends: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be drawn."""
        for name, ndim in (("subgoals", 3), ("actions", 2), ("paths", 3), ("ends", 3)):
            array = getattr(self, name)
            if array is not None and (array.ndim != ndim or array.shape[-1] != 3):
                raise InvalidOptionError(
                    f"PlanView.{name} has shape {array.shape}, expected {ndim} axes, the last of 3"
                )


@runtime_checkable
class Agent(Protocol):
    """Anything that acts. Third parties implement it without importing anything of ours.

    Optional class attributes, each taken as False when missing: ``needs_simulator`` (wants
    ``episode.simulator``) and ``needs_oracle`` (wants ``episode.oracle``). Optional method:
    ``plan_view() -> PlanView | None``, asked after ``act`` by those who draw.
    """

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; ``seed`` is the only source of randomness an agent may use."""
        ...

    def act(self, observation: Observation) -> FloatArray:
        """Return an action, (3,) in [-1, 1]."""
        ...
