"""Models that differ from the truth in what is hard to know: stiffness, mass and friction."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from icd_envs.physics.simulator import RolloutSimulator


def mismatched(
    simulator: RolloutSimulator, stiffness: float, mass: float, friction: float
) -> RolloutSimulator:
    """Let a simulator roll out with a changed copy of its model.

    Args:
        simulator: changed and returned.
        stiffness: of the object's hinges, as a multiple.
        mass: of the object, as a multiple.
        friction: sliding friction of everything, as a multiple.
    """
    simulator.model = changed(simulator.model, stiffness, mass, friction)
    return simulator


def changed(
    model: mujoco.MjModel, stiffness: float, mass: float, friction: float
) -> mujoco.MjModel:
    """A copy of a model with other mechanics; see ``mismatched``."""
    other = copy.copy(model)
    hinges = np.flatnonzero(other.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE))
    other.jnt_stiffness[hinges] *= stiffness
    # Bodies of the object: those that hinge, and whatever is rigidly attached to them.
    of_object = np.isin(other.body_weldid, other.jnt_bodyid[hinges])
    other.body_mass[of_object] *= mass
    other.body_inertia[of_object] *= mass
    other.geom_friction[:, 0] *= friction
    other.pair_friction[:, :2] *= friction
    mujoco.mj_setConst(other, mujoco.MjData(other))
    return other
