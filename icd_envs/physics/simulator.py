"""Batched rollouts for planners: one shared model, one scratch state per thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

import mujoco
import numpy as np

from icd_envs.api import Float64Array, FloatArray, Rollout, SimState
from icd_envs.errors import EpisodeStateError, IncompatibleStateError, InvalidActionError
from icd_envs.physics.guard import diverged, quiet_mujoco
from icd_envs.physics.plant import INTEGRATION, Plant, check_snapshot
from icd_envs.physics.threads import RolloutThreads
from icd_envs.scenes.arena import SUBSTEPS

FULL: Final = mujoco.mjtState.mjSTATE_FULLPHYSICS


class Trace(NamedTuple):
    """What MuJoCo returns for K samples of T physics steps.

    Attributes:
        states: (K, T, S) full physics state after each step; column 0 is the time [s].
        sensors: (K, T, 3P) tracked positions [m] before each step.
        end_time: [s] that every sample should have reached.
    """

    states: Float64Array
    sensors: Float64Array
    end_time: float


class RolloutSimulator:
    """The environment's own dynamics, rolled out in parallel (``icd_envs.api.Simulator``).

    Attributes:
        model: what is rolled out; may be replaced by one of the same sizes, for this one alone.
    """

    def __init__(
        self,
        plant: Plant,
        snapshot: Callable[[], SimState],
        signed_distance: Callable[[FloatArray], Float64Array],
        threads: RolloutThreads,
    ) -> None:
        """Share the environment's model and threads.

        Args:
            plant: the environment's scene; only its model is used.
            snapshot: returns the environment's state now.
            signed_distance: (M, 3) points [m] -> (M,) [m] to the scene's obstacles.
            threads: of the same scene; whoever made them stops them.
        """
        self._plant = plant
        self.model = plant.model
        self._snapshot = snapshot
        self._signed_distance = signed_distance
        self._threads = threads

    def snapshot(self) -> SimState:
        """State of the environment now."""
        return self._snapshot()

    def signed_distance(self, points: FloatArray) -> Float64Array:
        """(M, 3) [m] -> (M,) [m], negative inside a fixture; the floor does not count."""
        return self._signed_distance(points)

    def rollout(self, state: SimState, actions: FloatArray) -> Rollout:
        """Roll out K action sequences from one state; see ``icd_envs.api.Simulator``.

        Raises:
            InvalidActionError: if ``actions`` is not a finite (K, H, 3) array with K, H >= 1.
            IncompatibleStateError: if the state is no snapshot, of another scene or not finite.
            EpisodeStateError: once the environment was reset or closed.
        """
        if self._threads.closed:
            raise EpisodeStateError(
                "rollout on a simulator that reset or close has stopped: ask the environment's "
                "episode(simulator=True) for a new one"
            )
        try:
            sequences: Float64Array = np.asarray(actions, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidActionError(
                f"actions of type {type(actions).__name__} does not convert to an array of shape "
                f"(K, H, 3): {error}"
            ) from error
        if sequences.ndim != 3 or sequences.shape[2] != 3 or 0 in sequences.shape:
            raise InvalidActionError(f"actions has shape {sequences.shape}, expected (K, H, 3)")
        if not np.all(np.isfinite(sequences)):
            raise InvalidActionError("actions holds NaN or infinite values: send finite numbers")
        check_snapshot(state)
        if state.scene_id != self._plant.scene_id:
            raise IncompatibleStateError(
                f"state.scene_id is {state.scene_id!r}, this simulator's scene is "
                f"{self._plant.scene_id!r}: take a new snapshot after every reset"
            )
        self._plant.check_state(state.physics)
        trace = self.integrate(state, sequences)
        nodes = trace.sensors[:, SUBSTEPS::SUBSTEPS].reshape(*sequences.shape[:2], -1, 3)
        gripper = trace.states[:, SUBSTEPS - 1 : -1 : SUBSTEPS, 1 + self._plant.gripper_qpos]
        failed = diverged(nodes, trace.end_time, trace.states[:, -1, 0])
        if failed.any():
            # Void, but finite: every entry shows the state the rollout began in.
            with self._threads.lock:
                scratch = self._load(state)
                nodes[failed] = scratch.site_xpos[self._plant.node_sites]
                gripper[failed] = scratch.qpos[self._plant.gripper_qpos]
        return Rollout(self._plant.cloud(nodes), gripper.astype(np.float32), failed)

    def integrate(self, state: SimState, actions: Float64Array) -> Trace:
        """The bare physics of a rollout: K x (H x SUBSTEPS + 1) steps of MuJoCo.

        Args:
            state: where every sample begins; not checked.
            actions: (K, H, 3), clipped to [-1, 1].
        """
        model, threads = self.model, self._threads
        # Sensors are read at the start of a physics step: one step more shows the last state.
        control = np.clip(actions, -1.0, 1.0) * self._plant.velocity_scale
        control = np.repeat(control, SUBSTEPS, axis=1)
        control = np.concatenate([control, control[:, -1:]], axis=1)
        initial = np.empty(mujoco.mj_stateSize(model, FULL))
        with threads.lock, quiet_mujoco():
            scratch = self._load(state)
            mujoco.mj_getState(model, scratch, initial, FULL)
            warmstart = scratch.qacc_warmstart.copy()
            states, sensors = threads.pool.rollout(
                model, threads.scratch, initial, control, initial_warmstart=warmstart
            )
        end_time = initial[0] + control.shape[1] * float(model.opt.timestep)
        return Trace(states, sensors, float(end_time))

    def _load(self, state: SimState) -> mujoco.MjData:
        scratch = self._threads.scratch[0]
        mujoco.mj_setState(self.model, scratch, state.physics, INTEGRATION)
        mujoco.mj_kinematics(self.model, scratch)
        return scratch
