"""What a camera sees of points, against scenes where the answer is known."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from icd_envs.physics.camera import ASPECT, PointCamera

# Looks down from 2 m; a wall of 20 cm x 20 cm hangs at 1 m, a hand at 1 m beside it.
XML = """
<mujoco><worldbody>
  <camera name="top" pos="0 0 2" xyaxes="1 0 0 0 1 0" fovy="90"/>
  <geom name="floor" type="plane" size="3 3 0.1" group="0"/>
  <geom name="wall" type="box" pos="0 0 1" size="0.1 0.1 0.005" group="1"/>
  <geom name="hand" type="box" pos="0.5 0 1" size="0.1 0.1 0.005" group="3"/>
  <geom name="unseen" type="box" pos="-0.5 0 1" size="0.1 0.1 0.005" group="4"/>
  <geom name="cable" type="capsule" fromto="0 0.5 0.1 0 0.9 0.1" size="0.008" group="2"/>
</worldbody></mujoco>
"""


@pytest.fixture(scope="module")
def scene() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


@pytest.mark.parametrize(
    ("point", "seen"),
    [
        ([1.0, 1.0, 0.0], True),
        ([0.0, 0.0, 0.0], False),  # below the wall
        ([0.0, 0.0, 1.005], True),  # on it
        ([0.0, 0.0, 0.995], False),  # on its underside
        ([0.19, 0.0, 0.0], False),  # in the wall's shadow, twice its size
        ([0.21, 0.0, 0.0], True),
        ([1.0, 0.0, 0.0], False),  # below the hand
        ([-1.0, 0.0, 0.0], True),  # what pictures do not show hides nothing
        ([0.0, 0.7, 0.1], True),  # inside the object, on its centre line
        ([0.0, 0.7, 0.0], False),  # on the floor below it
        ([0.3, 0.3, 1.9], False),  # beside the picture
        ([0.0, 0.0, 2.5], False),  # behind the camera
        ([0.0, 0.0, 1.5], True),  # in the air
        ([0.0, 0.0, 2.0], False),  # the camera's own place
        ([0.0, 0.0, np.nan], False),
        ([np.inf, 0.0, 0.0], False),
    ],
)
def test_point_is_seen_unless_something_is_before_it(
    scene: tuple[mujoco.MjModel, mujoco.MjData], point: list[float], seen: bool
) -> None:
    model, data = scene
    assert PointCamera(model, "top").sees(data, np.array([point])).tolist() == [seen]


def test_picture_ends_where_the_field_of_view_does(
    scene: tuple[mujoco.MjModel, mujoco.MjData],
) -> None:
    model, data = scene
    height = 2.0  # at the floor, 2 m from the camera, half the picture at 90 degrees
    edges = np.array([[ASPECT * height, 0, 0], [-ASPECT * height, 0, 0], [0, -height, 0]])
    camera = PointCamera(model, "top")
    assert camera.sees(data, 0.99 * edges).all()
    assert not camera.sees(data, 1.01 * edges).any()


def test_each_point_is_judged_alone(scene: tuple[mujoco.MjModel, mujoco.MjData]) -> None:
    model, data = scene
    camera = PointCamera(model, "top")
    points = np.random.default_rng(0).uniform([-1, -1, 0], [1, 1, 0], (300, 3))
    together = camera.sees(data, points)
    assert 0 < together.sum() < len(points)
    for i in range(0, 300, 10):
        assert camera.sees(data, points[i : i + 1])[0] == together[i]
    assert camera.sees(data, points[:0]).shape == (0,)
    doubled = np.repeat(points, 2, axis=0).astype(np.float32)
    np.testing.assert_array_equal(camera.sees(data, doubled), np.repeat(together, 2))
    holed = points.copy()
    holed[::2] = np.nan
    seen = camera.sees(data, holed)
    assert not seen[::2].any()
    np.testing.assert_array_equal(seen[1::2], together[1::2])
