"""A window on the desktop that shows a scene; MuJoCo's own viewer, which never touches the state.

The viewer gets a copy of the state: opening it calls ``mj_forward``, which changes the solver's
warm start, and dragging in it applies forces.
"""

from __future__ import annotations

import sys
import threading
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from icd_envs.api import FloatArray
from icd_envs.errors import RenderingUnavailableError
from icd_envs.rendering import has_display
from icd_envs.scenes.layers import VISIBLE_GROUPS

if TYPE_CHECKING:
    import mujoco

    from icd_envs.drawing import Overlay

WINDOW_FIX: Final = (
    "start on a desktop, or give the process a display (ssh -X, xvfb-run),\n"
    'or do without a window: render_mode="rgb_array", or icd-bench watch in a browser'
)
CLOSING_SECONDS: Final = 5.0


class Window:
    """One scene in a window of its own; the person at the desktop turns the view."""

    def __init__(
        self, model: mujoco.MjModel, camera: str, on_key: Callable[[int], None] | None = None
    ) -> None:
        """Open it.

        Args:
            model: the scene.
            camera: name of the camera from which it is first seen.
            on_key: is told GLFW's code of every key pressed, in a thread of the viewer.

        Raises:
            RenderingUnavailableError: if there is no display, or no window opens on it.
        """
        check_display()
        import mujoco
        import mujoco.viewer

        self._model = model
        self._data = mujoco.MjData(model)
        others = set(threading.enumerate())
        try:
            self._viewer = mujoco.viewer.launch_passive(
                model, self._data, key_callback=on_key, show_left_ui=False, show_right_ui=False
            )
        except RuntimeError as error:  # on macOS, where Python must be started as mjpython
            raise RenderingUnavailableError(f"no window: {error}\n{WINDOW_FIX}") from error
        self._threads = set(threading.enumerate()) - others
        with self._viewer.lock():
            self._viewer.opt.geomgroup[:] = VISIBLE_GROUPS
            fixed = self._data.camera(camera)
            look_from(self._viewer.cam, fixed.xpos, fixed.xmat.reshape(3, 3))

    @property
    def is_open(self) -> bool:
        """Whether nobody has closed it."""
        return bool(self._viewer.is_running())

    def draw(self, data: mujoco.MjData, overlay: Overlay, text: str = "") -> None:
        """Show a state; nothing happens in a window that was closed.

        Args:
            data: state; its positions must be up to date.
            overlay: drawn on top.
            text: lines for the upper left corner.
        """
        import mujoco

        if not self.is_open:
            return
        with self._viewer.lock():
            mujoco.mj_copyData(self._data, self._model, data)
            mujoco.mj_camlight(self._model, self._data)
            self._viewer.user_scn.ngeom = 0
            overlay.add_to(self._viewer.user_scn)
        if text:
            self._viewer.set_texts((None, None, text, ""))
        self._viewer.sync()

    def close(self) -> None:
        """Close it and wait until its threads have let go of OpenGL; a second call does nothing."""
        self._viewer.close()
        for thread in self._threads:  # else the interpreter may crash as it ends
            thread.join(CLOSING_SECONDS)


def look_from(view: mujoco.MjvCamera, position: FloatArray, axes: FloatArray) -> None:
    """Let a free camera, which a person can turn, begin where a fixed one stands.

    Args:
        view: the free camera, changed.
        position: (3,) [m] of the fixed one.
        axes: (3, 3) columns are its right, its up and the way back from its picture.
    """
    import mujoco

    forward, up = -axes[:, 2], axes[:, 1]
    # Down to the floor; a camera that looks up or far away turns about a point 1 m before it.
    distance = -position[2] / forward[2] if forward[2] < -0.1 else 1.0
    ahead = forward[:2] + up[:2]  # seen from above, also if the camera looks straight down
    view.type = mujoco.mjtCamera.mjCAMERA_FREE
    view.lookat[:] = position + distance * forward
    view.distance = distance
    view.azimuth = np.degrees(np.arctan2(ahead[1], ahead[0]))
    view.elevation = np.degrees(np.arcsin(forward[2]))


def check_display() -> None:
    """Make sure that a window can open: MuJoCo's viewer would wait for ever if none can.

    Raises:
        RenderingUnavailableError: if it cannot.
    """
    if not has_display():
        raise RenderingUnavailableError(
            f"there is no display to open a window on (DISPLAY is not set)\n{WINDOW_FIX}"
        )
    if sys.platform != "linux":
        return
    import glfw

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        probe = None
        if glfw.init():
            glfw.window_hint(glfw.VISIBLE, False)
            probe = glfw.create_window(1, 1, "", None, None)
            glfw.default_window_hints()
    if not probe:
        reason = "; ".join(str(warning.message) for warning in said)
        raise RenderingUnavailableError(f"no window opens here: {reason}\n{WINDOW_FIX}")
    glfw.destroy_window(probe)
