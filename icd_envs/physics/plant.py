"""A compiled scene and its state: the one place where MuJoCo steps an environment."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from icd_envs.api import Float32Array, Float64Array, FloatArray, SimState
from icd_envs.errors import IncompatibleStateError
from icd_envs.physics.guard import BOUND, quiet_mujoco
from icd_envs.scenes.arena import SUBSTEPS

INTEGRATION: Final = mujoco.mjtState.mjSTATE_INTEGRATION
SLIDES: Final = ("slide_x", "slide_y", "slide_z")
FULL_BUFFERS: Final = (mujoco.mjtWarning.mjWARN_CONTACTFULL, mujoco.mjtWarning.mjWARN_CNSTRFULL)
UNSTABLE: Final = [
    int(kind)
    for kind in mujoco.mjtWarning.__members__.values()
    if kind not in (*FULL_BUFFERS, mujoco.mjtWarning.mjNWARNING)
]


@dataclass(frozen=True)
class TrackedCloud:
    """How the object cloud follows from the tracked nodes: point i lies between two nodes.

    Interpolation is elementwise, not a matrix product, so that a batch of states gives the same
    bits as each state alone.

    Attributes:
        start: (N,) index of the node before each point.
        share: (N, 1) position between that node and the next, in [0, 1].
    """

    start: NDArray[np.int64]
    share: Float64Array

    def __call__(self, nodes: Float64Array) -> Float32Array:
        """(..., P, 3) node positions -> (..., N, 3) float32 cloud [m]."""
        return self.between(nodes).astype(np.float32)

    def between(self, nodes: Float64Array) -> Float64Array:
        """The same, not yet rounded to float32."""
        first = nodes[..., self.start, :]
        return first + self.share * (nodes[..., self.start + 1, :] - first)


@dataclass(frozen=True)
class TrackedSheet:
    """How the object cloud follows from nodes in pairs: the left and right end of each edge.

    Attributes:
        along: where each point lies along either side.
        across: (N, 1) position between the left and the right side, in [0, 1].
    """

    along: TrackedCloud
    across: Float64Array

    def __call__(self, nodes: Float64Array) -> Float32Array:
        """(..., P, 3) node positions, left and right in turn -> (..., N, 3) float32 cloud [m]."""
        left = self.along.between(nodes[..., 0::2, :])
        right = self.along.between(nodes[..., 1::2, :])
        return (left + self.across * (right - left)).astype(np.float32)


def check_snapshot(state: object) -> None:
    """Refuse what is no snapshot at all.

    Raises:
        IncompatibleStateError: naming its type.
    """
    if not isinstance(state, SimState):
        raise IncompatibleStateError(
            f"state is of type {type(state).__name__}, expected icd_envs.api.SimState: pass what "
            "snapshot() returned"
        )


class Plant:
    """One scene: model, state, the gripper's servos and the tracked object.

    Every model has slides ``slide_x|y|z`` driven by velocity servos of the same names, a site
    ``grasp`` and sites ``node_0 ...`` each with a position sensor of its name, in order.
    """

    def __init__(self, xml: str, cloud: TrackedCloud | TrackedSheet, action_scale: float) -> None:
        """Compile a scene.

        Args:
            xml: MJCF text.
            cloud: object cloud from the tracked nodes.
            action_scale: [m] gripper translation per control step for an action of 1.
        """
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        self.cloud = cloud
        self.scene_id = hashlib.sha256(xml.encode()).hexdigest()[:16]
        self.control_period = SUBSTEPS * float(self.model.opt.timestep)
        self.velocity_scale = action_scale / self.control_period
        joints = [self.model.joint(name) for name in SLIDES]
        self.gripper_qpos = np.array([joint.qposadr[0] for joint in joints])
        self.gripper_qvel = np.array([joint.dofadr[0] for joint in joints])
        count = int(self.model.nsensor)
        self.node_sites = np.array([self.model.site(f"node_{i}").id for i in range(count)])
        with quiet_mujoco():
            mujoco.mj_forward(self.model, self.data)

    def step(self, action: FloatArray) -> None:
        """Advance one control step.

        Args:
            action: (3,) in [-1, 1].
        """
        self.data.ctrl[:] = np.asarray(action, dtype=np.float64) * self.velocity_scale
        with quiet_mujoco():
            mujoco.mj_step(self.model, self.data, SUBSTEPS)
        # Positions only: mj_forward would change the solver's warm start and with it the bits.
        mujoco.mj_kinematics(self.model, self.data)

    def nodes(self) -> Float64Array:
        """(P, 3) [m] tracked nodes now."""
        return self.data.site_xpos[self.node_sites]

    def points(self) -> Float32Array:
        """(N, 3) float32 [m] object cloud now."""
        return self.cloud(self.nodes())

    def gripper(self) -> Float64Array:
        """(3,) [m] gripper position now."""
        return self.data.qpos[self.gripper_qpos]

    def gripper_velocity(self) -> Float64Array:
        """(3,) [m/s] gripper velocity now."""
        return self.data.qvel[self.gripper_qvel]

    def motion(self) -> Float32Array:
        """(6,) what is observed of the gripper: position [m] and velocity [m/s], within bounds."""
        motion = np.concatenate([self.gripper(), self.gripper_velocity()])
        return np.asarray(np.clip(motion, -BOUND, BOUND), dtype=np.float32)

    def diverged(self) -> bool:
        """Whether the physics blew up since the state was last set."""
        return bool(self.data.warning.number[UNSTABLE].any()) or not bool(
            np.all(np.abs(self.nodes()) < BOUND)
        )

    def buffer_overflows(self) -> int:
        """How often a contact or constraint buffer was full since the state was last set."""
        return sum(int(self.data.warning[int(kind)].number) for kind in FULL_BUFFERS)

    def get_state(self) -> Float64Array:
        """(S,) whole integration state, a copy."""
        state = np.empty(mujoco.mj_stateSize(self.model, INTEGRATION))
        mujoco.mj_getState(self.model, self.data, state, INTEGRATION)
        return state

    def check_state(self, state: Float64Array) -> None:
        """Refuse a state that this model cannot continue from.

        Raises:
            IncompatibleStateError: if its size is not this model's, or if it is not finite.
        """
        size = mujoco.mj_stateSize(self.model, INTEGRATION)
        if state.shape != (size,):
            raise IncompatibleStateError(
                f"state.physics has shape {state.shape}, this scene needs ({size},): restore it in "
                "an environment reset with the same seed, split and options"
            )
        if not np.all(np.isfinite(state)):
            raise IncompatibleStateError(
                "state.physics holds NaN or infinite values: the physics had diverged when it was "
                "taken; take a snapshot before that"
            )

    def set_state(self, state: Float64Array) -> None:
        """Return to a state from ``get_state``.

        Raises:
            IncompatibleStateError: see ``check_state``; nothing has changed then.
        """
        self.check_state(state)
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, state, INTEGRATION)
        mujoco.mj_kinematics(self.model, self.data)
