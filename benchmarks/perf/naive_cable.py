"""The obvious cable to compare with: 30 ball joints, capsules that touch everything."""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np
from dm_control import mjcf

from icd_envs.api import Float32Array, Float64Array
from icd_envs.scenes.arena import make_arena
from icd_envs.scenes.cable_routing import WORKSPACE, CableRoutingScene
from icd_envs.scenes.clip import add_clip
from icd_envs.scenes.gripper import add_gripper

LINKS: Final = 30


def make_naive(
    scene: CableRoutingScene, points: Float32Array
) -> tuple[mujoco.MjModel, Float64Array]:
    """The same scene, with MuJoCo's default solver settings and collision rules for the cable.

    Args:
        scene: clips and cable.
        points: (N, 3) [m] cloud along the cable that its joints are set to.

    Returns:
        the model and its full physics state, (S,).
    """
    root = make_arena("naive")
    root.option.iterations = 100
    root.option.integrator = "Euler"
    root.option.jacobian = "auto"
    for i, clip in enumerate(scene.clips):
        add_clip(root, clip, f"clip_{i}")
    _add_chain(root, scene)
    add_gripper(root, np.array(WORKSPACE))
    root.equality.add("connect", name="grasp", site1="grasp", site2="tip")
    model = mujoco.MjModel.from_xml_string(root.to_xml_string())
    data = mujoco.MjData(model)
    _pose_chain(model, data, points.astype(np.float64))
    mujoco.mj_forward(model, data)
    tip = data.site("tip").xpos.copy()
    for i, axis in enumerate("xyz"):
        data.joint(f"slide_{axis}").qpos[:] = tip[i]
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, state, full)
    return model, state


def _add_chain(root: mjcf.RootElement, scene: CableRoutingScene) -> None:
    spec = scene.cable
    step = spec.length / LINKS
    body = root.worldbody.add("body", name="link_0", pos=scene.anchor)
    for i in range(LINKS):
        if i:
            body = body.add("body", name=f"link_{i}", pos=[step, 0, 0])
        body.add(
            "joint", name=f"ball_{i}", type="ball", stiffness=spec.stiffness if i else 0.0,
            damping=spec.damping, armature=spec.armature,
        )  # fmt: skip
        body.add(
            "geom", name=f"cable_{i}", type="capsule", fromto=[0, 0, 0, step, 0, 0],
            size=[spec.radius], mass=spec.density * step, friction=[spec.friction, 0.005, 0.0001],
            contype=3, conaffinity=3,
        )  # fmt: skip
    body.add("site", name="tip", pos=[step, 0, 0])


def _pose_chain(model: mujoco.MjModel, data: mujoco.MjData, points: Float64Array) -> None:
    nodes = points[np.linspace(0, len(points) - 1, LINKS + 1).round().astype(int)]
    parent = np.array([1.0, 0.0, 0.0, 0.0])
    for i, direction in enumerate(np.diff(nodes, axis=0)):
        world, inverse, joint = np.empty(4), np.empty(4), np.empty(4)
        _turn_x_to(direction / np.linalg.norm(direction), world)
        mujoco.mju_negQuat(inverse, parent)
        mujoco.mju_mulQuat(joint, inverse, world)
        data.qpos[model.joint(f"ball_{i}").qposadr[0] :][:4] = joint
        parent = world


def _turn_x_to(direction: Float64Array, quaternion: Float64Array) -> None:
    axis = np.cross([1.0, 0.0, 0.0], direction)
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 1e-9 else np.array([0.0, 0.0, 1.0])
    mujoco.mju_axisAngle2Quat(quaternion, axis, float(np.arctan2(sine, direction[0])))
