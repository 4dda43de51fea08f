from __future__ import annotations

import mujoco
import numpy as np
import pytest
import trimesh

from icd_envs.errors import SceneExportError
from icd_envs.physics.gltf import as_trimesh
from tests.envs.glb import check_meshes, reloaded

TOY = """
<mujoco>
  <asset>
    <texture name="two" type="2d" builtin="flat" rgb1="0.2 0.4 0.6" width="8" height="8"/>
    <material name="two" texture="two"/>
    <material name="plain" rgba="0.3 0.6 0.9 1"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
  </asset>
  <worldbody>
    <geom name="ground" type="plane" size="2 3 0.1" material="two"/>
    <geom name="hidden" type="sphere" size="9" group="4"/>
    <geom name="wedge" type="mesh" mesh="wedge" pos="5 6 7"/>
    <body pos="1 2 3" euler="30 40 50">
      <geom name="block" type="box" size="0.1 0.2 0.3" rgba="1 0 0 1"/>
      <geom type="sphere" size="0.2" material="plain"/>
      <geom name="ghost" type="cylinder" size="0.1 0.4" pos="1 0 0" rgba="0 1 0 0.5"/>
      <geom name="pill" type="capsule" size="0.1 0.4" material="plain" rgba="0 0 1 1"/>
    </body>
  </worldbody>
</mujoco>
"""


def compiled(geoms: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    text = geoms if "<mujoco>" in geoms else f"<mujoco><worldbody>{geoms}</worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def test_every_shape_keeps_its_place_size_and_volume() -> None:
    model, data = compiled(TOY)
    meshes = reloaded(as_trimesh(model, data).export(file_type="glb"))
    check_meshes(meshes, model, data)
    np.testing.assert_allclose(meshes["wedge"].bounds, [[5, 6, 7], [6, 7, 8]], atol=1e-6)
    assert meshes["wedge"].volume == pytest.approx(1 / 6)
    assert "hidden" not in meshes


def test_height_is_y_in_the_file() -> None:
    scene = as_trimesh(*compiled('<geom type="box" size=".1 .2 .3" pos="1 2 3"/>'))
    np.testing.assert_allclose(scene.bounds, [[0.9, 2.7, -2.2], [1.1, 3.3, -1.8]])


@pytest.mark.parametrize(
    ("name", "rgba"),
    [
        ("block", (1, 0, 0, 1)),
        ("ghost", (0, 1, 0, 0.5)),
        ("ground", (0.2, 0.4, 0.6, 1)),  # the mean of its texture
        ("geom_4", (0.3, 0.6, 0.9, 1)),  # its material's
        ("pill", (0, 0, 1, 1)),  # its own before its material's
    ],
)
def test_colours_are_those_of_the_pictures(name: str, rgba: tuple[float, ...]) -> None:
    meshes = reloaded(as_trimesh(*compiled(TOY)).export(file_type="glb"))
    material = meshes[name].visual.material
    factor = trimesh.visual.color.to_float(material.baseColorFactor)
    shown = [*trimesh.visual.color.linear_to_srgb(factor[:3]), factor[3]]
    np.testing.assert_allclose(shown, rgba, atol=0.02)
    assert material.alphaMode == ("OPAQUE" if rgba[3] == 1 else "BLEND")


@pytest.mark.parametrize(
    "shape",
    ['type="ellipsoid" size="1 2 3"', 'type="plane" size="0 0 1"', 'type="plane" size="2 0 1"'],
)
def test_shape_without_a_mesh_is_refused_by_name(shape: str) -> None:
    with pytest.raises(SceneExportError, match=r"'egg' .*known are mjGEOM_PLANE"):
        as_trimesh(*compiled(f'<geom name="egg" {shape}/>'))
