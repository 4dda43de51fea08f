"""A world with known answers: the object is a cloud fixed to the gripper, which goes where told."""

from __future__ import annotations

import numpy as np

from icd_envs.api import (
    BoolArray,
    Episode,
    Float64Array,
    FloatArray,
    Observation,
    Oracle,
    Rollout,
    SimState,
)

ACTION_SCALE = 0.03
POINTS = 5
OFFSETS = np.random.default_rng(0).uniform(-0.05, 0.05, (POINTS, 3))


def cloud_at(position: FloatArray) -> FloatArray:
    """Object clouds (..., N, 3) for gripper positions (..., 3)."""
    return (np.asarray(position)[..., None, :] + OFFSETS).astype(np.float32)


class ToyWorld:
    """A linear integrator and, if given, one ball as the only obstacle."""

    def __init__(
        self,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
        goal: tuple[float, float, float] = (0.3, 0.0, 0.0),
        ball: tuple[float, float, float] | None = None,
        ball_radius: float = 0.05,
        ends_on_success: bool = True,
    ) -> None:
        self.position = np.asarray(start, dtype=np.float64)
        self.goal = np.asarray(goal)
        self.ball = ball
        self.ball_radius = ball_radius
        self.ends_on_success = ends_on_success
        self.diverged: BoolArray | None = None
        self.void = 0.0
        self.last_actions: FloatArray | None = None
        self.last_rollout: Rollout | None = None

    def snapshot(self) -> SimState:
        return SimState("toy", "toy", self.position.copy())

    def rollout(self, state: SimState, actions: FloatArray) -> Rollout:
        self.last_actions = actions
        gripper = state.physics + ACTION_SCALE * np.cumsum(np.clip(actions, -1, 1), axis=1)
        diverged = np.zeros(len(actions), bool) if self.diverged is None else self.diverged
        points = cloud_at(gripper)
        points[diverged] = self.void
        self.last_rollout = Rollout(points, gripper.astype(np.float32), diverged)
        return self.last_rollout

    def signed_distance(self, points: FloatArray) -> Float64Array:
        if self.ball is None:
            return np.full(len(points), 1.0)
        distance: Float64Array = np.linalg.norm(points - np.asarray(self.ball), axis=1)
        return distance - self.ball_radius

    def step(self, action: FloatArray) -> None:
        self.position = self.position + ACTION_SCALE * np.clip(action, -1, 1)

    def observation(self) -> Observation:
        scene = np.zeros((4, 3), np.float32)
        return {
            "observation": np.r_[self.position, np.zeros(3)].astype(np.float32),
            "achieved_goal": cloud_at(self.position),
            "desired_goal": cloud_at(self.goal),
            "scene": scene,
            "goal_scene": scene,
        }

    def episode(self, oracle: Oracle | None = None) -> Episode:
        spheres = np.array([[0.0, 0.0, 0.0, 0.02]], np.float32)
        return Episode(
            "toy",
            ACTION_SCALE,
            0.05,
            100,
            OFFSETS.astype(np.float32),
            spheres,
            self,
            oracle,
            ends_on_success=self.ends_on_success,
        )
