"""Meshes against MuJoCo's own geoms."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import trimesh

from icd_envs.meshes import group_meshes

XML = """<mujoco><worldbody>
<geom name="floor" type="plane" size="1 1 1" group="1"/>
<body pos="1 2 3" euler="30 40 50">
  <geom name="box" type="box" size=".1 .2 .3" pos=".5 0 0" group="2" rgba="1 .5 .25 1"/>
  <geom name="cylinder" type="cylinder" size=".1 .4" group="2"/>
  <geom name="capsule" type="capsule" size=".1 .3" group="2"/>
  <geom name="ball" type="sphere" size=".2" group="2"/>
</body></worldbody></mujoco>"""

EXTENTS = {
    "box": (0.2, 0.4, 0.6),
    "cylinder": (0.2, 0.2, 0.8),
    "capsule": (0.2, 0.2, 0.8),
    "ball": (0.4, 0.4, 0.4),
}


@pytest.fixture(scope="module")
def scene() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def test_meshes_have_the_size_and_pose_of_the_geoms(
    scene: tuple[mujoco.MjModel, mujoco.MjData],
) -> None:
    model, data = scene
    found = {mesh.name: mesh for mesh in group_meshes(model, data, 2)}
    assert set(found) == set(EXTENTS)
    for name, extent in EXTENTS.items():
        mesh = trimesh.Trimesh(found[name].vertices, found[name].faces)
        np.testing.assert_allclose(mesh.extents, extent, rtol=0.02)
        np.testing.assert_allclose(mesh.bounds.mean(axis=0), 0.0, atol=1e-6)
        assert mesh.is_watertight
        assert mesh.volume > 0
        np.testing.assert_array_equal(found[name].position, data.geom(name).xpos)
        np.testing.assert_array_equal(found[name].rotation.ravel(), data.geom(name).xmat)
    np.testing.assert_allclose(found["box"].rgba, (1.0, 0.5, 0.25, 1.0))


def test_meshes_keep_their_place_when_the_scene_moves(
    scene: tuple[mujoco.MjModel, mujoco.MjData],
) -> None:
    model, data = scene
    (box, *_) = group_meshes(model, data, 2)
    before = box.position.copy()
    data.geom_xpos[:] += 1.0
    np.testing.assert_array_equal(box.position, before)
    data.geom_xpos[:] -= 1.0
