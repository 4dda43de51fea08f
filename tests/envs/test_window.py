"""The desktop window: on a fake viewer, on none, and on a real one where Xvfb is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator

import glfw
import mujoco
import mujoco.viewer
import numpy as np
import pytest

from icd_envs import window
from icd_envs.drawing import Overlay
from icd_envs.errors import RenderingUnavailableError
from icd_envs.window import Window, look_from
from tests.envs import fake_viewer
from tests.envs.fake_viewer import FakeViewer

XML = """<mujoco><worldbody>
<camera name="overview" pos="1 -1 1" xyaxes="1 1 0 -1 1 2"/>
<body><freejoint/><geom size=".1"/></body>
</worldbody></mujoco>"""
GOAL = np.zeros((5, 3), np.float32)


@pytest.fixture
def viewers(monkeypatch: pytest.MonkeyPatch) -> list[FakeViewer]:
    return fake_viewer.install(monkeypatch)


@pytest.fixture
def scene() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 3)
    return model, data


def test_window_shows_the_state_and_never_touches_it(
    viewers: list[FakeViewer], scene: tuple[mujoco.MjModel, mujoco.MjData]
) -> None:
    model, data = scene
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    before = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, before, kind)
    opened = Window(model, "overview")
    opened.draw(data, Overlay(GOAL))
    opened.draw(data, Overlay(GOAL[:2]), "hello")
    (viewer,) = viewers
    assert viewer.data is not data
    np.testing.assert_array_equal(viewer.data.qpos, data.qpos)
    assert viewer.shown == [5, 2]
    assert viewer.texts == ["hello"]
    after = np.empty_like(before)
    mujoco.mj_getState(model, data, after, kind)
    np.testing.assert_array_equal(after, before)


def test_closed_window_stays_closed(
    viewers: list[FakeViewer], scene: tuple[mujoco.MjModel, mujoco.MjData]
) -> None:
    opened = Window(scene[0], "overview")
    assert opened.is_open
    viewers[0].running = False  # a person closed it
    opened.draw(scene[1], Overlay(GOAL))
    assert not opened.is_open
    assert viewers[0].shown == []
    opened.close()
    opened.close()


def test_keys_are_told(
    viewers: list[FakeViewer], scene: tuple[mujoco.MjModel, mujoco.MjData]
) -> None:
    pressed: list[int] = []
    Window(scene[0], "overview", pressed.append)
    assert viewers[0].key is not None
    viewers[0].key(32)
    assert pressed == [32]


def directions() -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Directions of view and what is up in the picture."""
    for azimuth in (-170, -90, 0, 33, 120):
        for elevation in (-90, -89, -45, -10, 0, 30):
            a, e = np.radians([azimuth, elevation])
            flat = np.array([np.cos(a), np.sin(a), 0.0])
            yield (
                np.cos(e) * flat + np.sin(e) * np.array([0.0, 0.0, 1.0]),
                -np.sin(e) * flat + np.cos(e) * np.array([0.0, 0.0, 1.0]),
            )


@pytest.mark.parametrize(("forward", "up"), [*directions()])
def test_free_camera_begins_where_the_fixed_one_stands(forward: np.ndarray, up: np.ndarray) -> None:
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    position = np.array([0.3, -0.2, 1.1])
    view = mujoco.MjvCamera()
    look_from(view, position, np.column_stack([np.cross(forward, up), up, -forward]))
    scene = mujoco.MjvScene(model, 10)
    mujoco.mjv_updateScene(
        model, data, mujoco.MjvOption(), None, view, mujoco.mjtCatBit.mjCAT_ALL, scene
    )
    seen = scene.camera[0]
    np.testing.assert_allclose(seen.pos, position, atol=0.05)  # half of the distance between eyes
    np.testing.assert_allclose(seen.forward, forward, atol=1e-5)
    np.testing.assert_allclose(seen.up, up, atol=1e-5)


def test_without_a_display_the_error_names_the_fix(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(RenderingUnavailableError) as caught:
        window.check_display()
    assert str(caught.value).endswith(window.WINDOW_FIX)
    assert window.WINDOW_FIX.count("\n") == 1


@pytest.mark.skipif(sys.platform != "linux", reason="only there the display is probed")
@pytest.mark.parametrize("starts", [True, False])
def test_display_on_which_no_window_opens_is_refused(
    monkeypatch: pytest.MonkeyPatch, starts: bool
) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(glfw, "init", lambda: starts)
    for name in ("window_hint", "default_window_hints", "create_window"):
        monkeypatch.setattr(glfw, name, lambda *_: None)
    with pytest.raises(RenderingUnavailableError, match="no window opens"):
        window.check_display()


def test_viewer_that_does_not_launch_is_our_error(
    monkeypatch: pytest.MonkeyPatch, scene: tuple[mujoco.MjModel, mujoco.MjData]
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise RuntimeError("run under mjpython")

    fake_viewer.install(monkeypatch)
    monkeypatch.setattr(mujoco.viewer, "launch_passive", refuse)
    with pytest.raises(RenderingUnavailableError, match="mjpython"):
        Window(scene[0], "overview")


SCRIPT = """
import threading
import gymnasium as gym
import numpy as np
import icd_envs
env = gym.make("ICDCableRouting-v0", render_mode="human")
alone = gym.make("ICDCableRouting-v0")
for seed in (0, 1):
    env.reset(seed=seed), alone.reset(seed=seed)
    for _ in range(3):
        seen, expected = (e.step(np.ones(3))[0] for e in (env, alone))
    assert env.render() is None
    assert all(np.array_equal(seen[name], expected[name]) for name in expected)
    assert env.unwrapped._screen._window.is_open
env.close()
assert threading.enumerate() == [threading.main_thread()]
print("shown")
"""


@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="needs Xvfb, a display in memory")
def test_real_window_opens_for_every_scene_and_changes_no_bit() -> None:
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    done = subprocess.run(
        ["xvfb-run", "-a", sys.executable, "-c", SCRIPT],
        env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == "shown\n"
