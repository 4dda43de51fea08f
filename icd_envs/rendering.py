"""Pictures of a scene, with or without a display; physics and the benchmark never need it."""

from __future__ import annotations

import ctypes.util
import os
import sys
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from icd_envs.api import Float32Array
from icd_envs.errors import RenderingUnavailableError

if TYPE_CHECKING:
    import mujoco

    from icd_envs.drawing import Overlay

LIBRARIES: Final = {"egl": (("EGL",), ("OpenGL", "GL", "GLESv2")), "osmesa": (("OSMesa",),)}
"""What MuJoCo's backends load through PyOpenGL: one library of every group."""
DISABLED: Final = ("disable", "disabled", "off", "false", "0")
AUTOMATIC: Final = ("", "enable", "enabled", "on", "true", "1")

FIX: Final = (
    "install a software renderer, e.g. on Debian or Ubuntu: apt-get install libegl1 libgl1\n"
    "and start Python again with MUJOCO_GL=egl (or libosmesa6 and MUJOCO_GL=osmesa)"
)


def choose_backend() -> str:
    """Set ``MUJOCO_GL`` to a backend that works here; to be called before MuJoCo is imported.

    A value set by the user stays if it works. Otherwise, without a display, EGL comes first, then
    OSMesa; with neither, rendering is disabled and everything else works. MuJoCo itself would not
    even import with a backend whose libraries are missing or broken.

    Returns:
        the value ``MUJOCO_GL`` now has.
    """
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    if asked in (*DISABLED, "glfw") or "mujoco" in sys.modules:
        return asked
    if asked in LIBRARIES and _works(asked):
        return asked
    chosen = "glfw" if has_display() else next(_headless_backends(), "disabled")
    if asked not in AUTOMATIC:
        warnings.warn(
            f"MUJOCO_GL={asked!r} is not available here: using {chosen!r} instead", stacklevel=2
        )
    os.environ["MUJOCO_GL"] = chosen
    return chosen


def has_display() -> bool:
    """Whether a window could open, as far as the process's environment tells."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _headless_backends() -> Iterator[str]:
    return (name for name in LIBRARIES if _works(name))


def _works(backend: str) -> bool:
    """Whether the libraries load, and PyOpenGL was not told to use others."""
    platform = os.environ.get("PYOPENGL_PLATFORM", "").lower()
    groups = LIBRARIES[backend]
    return platform in ("", backend) and all(any(map(_loads, group)) for group in groups)


def _loads(library: str) -> bool:
    name = ctypes.util.find_library(library)
    try:
        return name is not None and ctypes.CDLL(name) is not None
    except OSError:
        return False


class SceneRenderer:
    """Off-screen pictures of one compiled scene."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int, camera: str) -> None:
        """Open a GL context.

        Args:
            model: the scene.
            width: [px]
            height: [px]
            camera: name of a camera of the scene.

        Raises:
            RenderingUnavailableError: if OpenGL does not start.
        """
        import mujoco

        from icd_envs.scenes.layers import VISIBLE_GROUPS

        self._model = model
        self._camera = camera
        try:
            self._renderer = mujoco.Renderer(model, height, width)
        except Exception as error:  # GL stacks fail with many types; the fix is the same
            backend = os.environ.get("MUJOCO_GL", "")
            raise RenderingUnavailableError(
                f"OpenGL did not start (MUJOCO_GL={backend!r}): {error}\n{FIX}"
            ) from error
        self._options = mujoco.MjvOption()
        self._options.geomgroup[:] = VISIBLE_GROUPS

    def rgb(self, data: mujoco.MjData, overlay: Overlay) -> NDArray[np.uint8]:
        """(height, width, 3) picture.

        Args:
            data: state; its positions must be up to date.
            overlay: goal and plan, drawn on top.
        """
        self._renderer.disable_depth_rendering()
        self._update(data)
        overlay.add_to(self._renderer.scene)
        return np.asarray(self._renderer.render())

    def depth(self, data: mujoco.MjData) -> Float32Array:
        """(height, width) distance from the camera plane [m], with nothing drawn on top."""
        self._renderer.enable_depth_rendering()
        self._update(data)
        return np.asarray(self._renderer.render(), dtype=np.float32)

    def _update(self, data: mujoco.MjData) -> None:
        import mujoco

        mujoco.mj_camlight(self._model, data)  # a plant that was only set has no cameras yet
        self._renderer.update_scene(data, self._camera, self._options)

    def close(self) -> None:
        """Free the GL context."""
        self._renderer.close()
