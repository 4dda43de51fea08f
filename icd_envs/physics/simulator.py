"""Batched rollouts for planners: one shared model, one scratch state per thread."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Final

import mujoco
import numpy as np
from mujoco import rollout

from icd_envs.api import Float64Array, FloatArray, Rollout, SimState
from icd_envs.errors import IncompatibleStateError, InvalidActionError
from icd_envs.physics.guard import diverged, quiet_mujoco
from icd_envs.physics.plant import INTEGRATION, Plant
from icd_envs.scenes.arena import SUBSTEPS

FULL: Final = mujoco.mjtState.mjSTATE_FULLPHYSICS


class RolloutSimulator:
    """The environment's own dynamics, rolled out in parallel (``icd_envs.api.Simulator``)."""

    def __init__(
        self,
        plant: Plant,
        snapshot: Callable[[], SimState],
        signed_distance: Callable[[FloatArray], Float64Array],
        threads: int,
    ) -> None:
        """Share the environment's model.

        Args:
            plant: the environment's scene; only its model is used.
            snapshot: returns the environment's state now.
            signed_distance: (M, 3) points [m] -> (M,) [m] to the scene's obstacles.
            threads: rollout threads, at least 1; results do not depend on it.
        """
        self._plant = plant
        self._snapshot = snapshot
        self._signed_distance = signed_distance
        self._scratch = [mujoco.MjData(plant.model) for _ in range(threads)]
        # With 0 pool threads MuJoCo rolls out on the calling one.
        self._pool = rollout.Rollout(nthread=threads if threads > 1 else 0)

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
            IncompatibleStateError: if the state belongs to another scene.
        """
        actions = np.asarray(actions, dtype=np.float64)
        if actions.ndim != 3 or actions.shape[2] != 3 or 0 in actions.shape:
            raise InvalidActionError(f"actions has shape {actions.shape}, expected (K, H, 3)")
        if not np.all(np.isfinite(actions)):
            raise InvalidActionError("actions holds NaN or infinite values: send finite numbers")
        if state.scene_id != self._plant.scene_id:
            raise IncompatibleStateError(
                f"state.scene_id is {state.scene_id!r}, this simulator's scene is "
                f"{self._plant.scene_id!r}: take a new snapshot after every reset"
            )
        model, scratch = self._plant.model, self._scratch[0]
        mujoco.mj_setState(model, scratch, state.physics, INTEGRATION)
        initial = np.empty(mujoco.mj_stateSize(model, FULL))
        mujoco.mj_getState(model, scratch, initial, FULL)
        warmstart = scratch.qacc_warmstart.copy()

        # Sensors are read at the start of a physics step: one step more shows the last state.
        samples, horizon, _ = actions.shape
        control = np.clip(actions, -1.0, 1.0) * self._plant.velocity_scale
        control = np.repeat(control, SUBSTEPS, axis=1)
        control = np.concatenate([control, control[:, -1:]], axis=1)
        with quiet_mujoco():
            states, sensors = self._pool.rollout(
                model, self._scratch, initial, control, initial_warmstart=warmstart
            )
        nodes = sensors[:, SUBSTEPS::SUBSTEPS].reshape(samples, horizon, -1, 3)
        gripper = states[:, SUBSTEPS - 1 : -1 : SUBSTEPS, 1 + self._plant.gripper_qpos]
        expected = initial[0] + control.shape[1] * float(model.opt.timestep)
        failed = diverged(nodes, expected, states[:, -1, 0])
        if failed.any():
            # Void, but finite: every entry shows the state the rollout began in.
            mujoco.mj_setState(model, scratch, state.physics, INTEGRATION)
            mujoco.mj_kinematics(model, scratch)
            nodes[failed] = scratch.site_xpos[self._plant.node_sites]
            gripper[failed] = scratch.qpos[self._plant.gripper_qpos]
        return Rollout(self._plant.cloud(nodes), gripper.astype(np.float32), failed)

    def close(self) -> None:
        """Stop the threads."""
        self._pool.close()

    def __enter__(self) -> RolloutSimulator:
        """Use as a context manager to stop the threads in the end."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Stop the threads."""
        self.close()
