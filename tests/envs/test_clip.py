from __future__ import annotations

import mujoco
import numpy as np
import pytest

from icd_envs.api import Float64Array
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.arena import make_arena
from icd_envs.scenes.boxes import rotation_z
from icd_envs.scenes.clip import LOCAL_BOXES, THROAT_X, Clip, add_clip, throat_height

POSES = pytest.mark.parametrize(
    "clip", [Clip((0.0, 0.0), 0.0), Clip((0.3, -0.2), 1.1), Clip((-0.4, 0.1), -2.9)]
)


def throat_points(count: int = 2000, margin: float = 1e-3) -> Float64Array:
    """Points of the throat, in the clip's frame, not nearer to its border than ``margin``."""
    rng = np.random.default_rng(0)
    x = rng.uniform(THROAT_X[0] + margin, THROAT_X[1] - margin, count)
    z = rng.uniform(margin, throat_height(x) - 2 * margin)
    return np.column_stack([x, np.zeros(count), z])


def placed(points: Float64Array, clip: Clip) -> Float64Array:
    return points @ rotation_z(clip.yaw).T + clip.origin


@POSES
def test_throat_is_free_and_wall_and_lip_bound_it(clip: Clip) -> None:
    solid = BoxUnion(clip.boxes())
    assert solid(placed(throat_points(), clip)).min() > 0
    z = np.linspace(0.005, 0.06, 20)
    wall = np.column_stack([np.full(20, THROAT_X[0] - 1e-4), np.zeros(20), z])
    assert solid(placed(wall, clip)).max() < 0
    x = np.linspace(THROAT_X[0], THROAT_X[1] - 1e-3, 20)
    lip = np.column_stack([x, np.zeros(20), throat_height(x) + 1e-4])
    assert solid(placed(lip, clip)).max() < 0


@POSES
def test_mouth_is_open(clip: Clip) -> None:
    z = np.linspace(0.006, throat_height(THROAT_X[1]) - 0.006, 20)
    x = np.linspace(THROAT_X[0] + 0.006, THROAT_X[1] + 0.2, 30)
    ways = np.stack(np.meshgrid(x, [0.0], z[z < throat_height(x[0]) - 0.006]), axis=-1)
    assert BoxUnion(clip.boxes())(placed(ways.reshape(-1, 3), clip)).min() > 0.004


@POSES
def test_boxes_stand_on_the_floor(clip: Clip) -> None:
    signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)
    for name, box in zip(LOCAL_BOXES, clip.boxes(), strict=True):
        lowest = (box.center + signs * box.half @ box.rotation.T)[:, 2].min()
        assert lowest > 0.01 if name == "lip" else lowest == pytest.approx(0.0, abs=1e-12)


@POSES
def test_frame_is_right_handed(clip: Clip) -> None:
    np.testing.assert_allclose(np.cross(clip.mouth, clip.axis), [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(clip.mouth[:2], [np.cos(clip.yaw), np.sin(clip.yaw)])


@POSES
def test_boxes_are_where_mujoco_puts_them(clip: Clip) -> None:
    root = make_arena("clip")
    add_clip(root, clip, "fixture")
    model = mujoco.MjModel.from_xml_string(root.to_xml_string())
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert model.ngeom == 1 + len(LOCAL_BOXES)
    for name, box in zip(LOCAL_BOXES, clip.boxes(), strict=True):
        geom = data.geom(f"fixture_{name}")
        np.testing.assert_allclose(geom.xpos, box.center, atol=1e-9)
        np.testing.assert_allclose(geom.xmat.reshape(3, 3), box.rotation, atol=1e-9)
        np.testing.assert_allclose(model.geom(geom.id).size, box.half, atol=1e-12)
        assert model.geom(geom.id).type == mujoco.mjtGeom.mjGEOM_BOX
