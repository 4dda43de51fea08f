"""Each GL backend is chosen once per process, so pictures are made in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from icd_envs import rendering
from icd_envs.errors import InvalidOptionError
from tests.envs.making import make

SCRIPT = """
import json, os, sys, warnings
import gymnasium as gym
import numpy as np
import icd_envs
from icd_envs.errors import RenderingUnavailableError

def visible(picture):
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    return int(np.sum((red > 90) & (red > 2 * green) & (red > 2 * blue)))

found = {}
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    view = {"split": "test", "width": 240, "height": 180}
    env = gym.make("ICDCableRouting-v0", render_mode="rgb_array", **view)
    observation, _ = env.reset(seed=0)
    found["warned"] = [str(w.message) for w in caught if "MUJOCO_GL" in str(w.message)]
found["moved"] = float(np.abs(env.step(np.ones(3))[0]["observation"]).max())
try:
    env.reset(seed=0)
    pictures = [env.render()]
    env.step(np.zeros(3))
    pictures += [env.render(), env.render()]
    found["shape"], found["dtype"] = pictures[0].shape, str(pictures[0].dtype)
    found["red"] = [visible(picture) for picture in pictures]
    found["bright"] = [float(np.mean(picture > 30)) for picture in pictures]
    found["stable"] = bool(np.array_equal(pictures[1], pictures[2]))
    found["change"] = float(np.mean(np.any(pictures[0] != pictures[1], axis=-1)))
    env.close()
    depth = gym.make("ICDCableRouting-v0", render_mode="depth_array", **view)
    depth.reset(seed=0)
    picture = depth.render()
    found["depth"] = [list(picture.shape), float(picture.min()), float(picture.max())]
    depth.close()
except RenderingUnavailableError as error:
    found["error"] = str(error)
env.close()
found["backend"] = os.environ.get("MUJOCO_GL")
found["files"] = os.listdir(".")
print(json.dumps(found))
"""


def outcome(folder: Path, backend: str | None) -> dict[str, Any]:
    """What happens in a process without a display."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL", "PYOPENGL_PLATFORM")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    if backend is not None:
        environment["MUJOCO_GL"] = backend
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["moved"] > 0
    assert found["files"] == []
    return found


def check_pictures(found: dict[str, Any]) -> None:
    if "error" in found:
        assert rendering.FIX in found["error"]
        return
    assert found["shape"] == [180, 240, 3]
    assert found["dtype"] == "uint8"
    assert min(found["red"]) > 50
    assert min(found["bright"]) > 0.5
    assert found["stable"]
    # A moment later the picture is nearly the same: the first one is not a view from elsewhere.
    assert found["change"] < 0.2
    shape, nearest, farthest = found["depth"]
    assert shape == [180, 240]
    assert 0.1 < nearest < farthest


@pytest.mark.parametrize("backend", [None, "nonsense"])
def test_picture_shows_the_goal_or_the_error_says_how(tmp_path: Path, backend: str | None) -> None:
    found = outcome(tmp_path, backend)
    check_pictures(found)
    assert found["backend"] in ("egl", "osmesa", "disabled")
    assert bool(found["warned"]) == (backend is not None)


@pytest.mark.parametrize("backend", ["disabled", "glfw"])
def test_without_opengl_only_rendering_raises(tmp_path: Path, backend: str) -> None:
    found = outcome(tmp_path, backend)
    assert rendering.FIX in found["error"]
    assert repr(backend) in found["error"]
    assert found["backend"] == backend


@pytest.mark.parametrize(
    ("asked", "display", "libraries", "chosen"),
    [
        ("", "", ("EGL", "GL", "OSMesa"), "egl"),
        ("", "", ("EGL", "OpenGL"), "egl"),
        ("", "", ("EGL", "GLESv2"), "egl"),
        ("", "", ("EGL", "OSMesa"), "osmesa"),
        ("", "", ("GL", "OSMesa"), "osmesa"),
        ("", "", ("EGL",), "disabled"),
        ("", "", (), "disabled"),
        ("", ":0", ("EGL", "GL"), "glfw"),
        ("egl", ":0", ("EGL", "GL"), "egl"),
        (" OSMesa ", "", ("EGL", "GL", "OSMesa"), "osmesa"),
        ("osmesa", "", ("EGL", "GL"), "egl"),
        ("egl", "", (), "disabled"),
        ("egl", "", ("EGL",), "disabled"),
        ("off", ":0", ("EGL", "GL"), "off"),
        ("glfw", "", ("EGL", "GL"), "glfw"),
        ("on", "", ("EGL", "GL"), "egl"),
    ],
)
@pytest.mark.parametrize("broken", [False, True], ids=["missing", "broken"])
@pytest.mark.filterwarnings("ignore:MUJOCO_GL")
def test_backend_is_the_first_that_works(
    monkeypatch: pytest.MonkeyPatch,
    asked: str,
    display: str,
    libraries: tuple[str, ...],
    chosen: str,
    broken: bool,
) -> None:
    pretend(monkeypatch, asked, libraries, broken)
    monkeypatch.setenv("DISPLAY", display)
    assert rendering.choose_backend() == chosen
    assert os.environ["MUJOCO_GL"].strip().lower() == chosen


@pytest.mark.parametrize(
    ("platform", "chosen"), [("", "egl"), ("EGL", "egl"), ("osmesa", "osmesa"), ("glx", "disabled")]
)
def test_backend_is_one_that_pyopengl_was_not_told_to_leave_alone(
    monkeypatch: pytest.MonkeyPatch, platform: str, chosen: str
) -> None:
    pretend(monkeypatch, "", ("EGL", "GL", "OSMesa"))
    monkeypatch.setenv("PYOPENGL_PLATFORM", platform)
    assert rendering.choose_backend() == chosen


def pretend(
    monkeypatch: pytest.MonkeyPatch, asked: str, libraries: tuple[str, ...], broken: bool = False
) -> None:
    """A fresh process on Linux without a display that has these libraries alone.

    The others are not there, or they are there and do not load.
    """

    def load(name: str) -> str:
        if name not in libraries:
            raise OSError(f"{name}: file too short")
        return name

    monkeypatch.delitem(sys.modules, "mujoco", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("MUJOCO_GL", asked)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "PYOPENGL_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(
        rendering.ctypes.util,
        "find_library",
        lambda name: name if broken or name in libraries else None,
    )
    monkeypatch.setattr(rendering.ctypes, "CDLL", load)


def test_without_render_mode_there_is_no_picture() -> None:
    env = make()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="render_mode"):
        assert env.render() is None
    env.close()


@pytest.mark.parametrize("name", ["width", "height"])
@pytest.mark.parametrize("size", [0, -1, 100_000, 1.5, "120", True, None, np.nan])
def test_impossible_size_is_refused(name: str, size: object) -> None:
    with pytest.raises(InvalidOptionError, match=name):
        make(**{name: size})
