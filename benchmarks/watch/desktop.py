"""A view on the desktop, in MuJoCo's own window."""

from __future__ import annotations

from typing import Any, Final

from benchmarks.watch.controls import Controls
from benchmarks.watch.session import Moment
from benchmarks.watch.text import describe
from icd_envs.drawing import Overlay
from icd_envs.tasks.env import ContactEnv
from icd_envs.window import Window

SPACE, RIGHT, ENTER, BACKSPACE = 32, 262, 257, 259
"""GLFW's codes; pause, step and reset are on the same keys in MuJoCo's own simulator."""
KEYS: Final = "space: play or pause\nright: single step\nenter: next episode\nbackspace: same again"


class DesktopView:
    """A window for each episode; closing it ends the watching."""

    def __init__(self, controls: Controls) -> None:
        """Wait for the first scene.

        Args:
            controls: operated by keys.
        """
        self._controls = controls
        self._window: Window | None = None
        self._episode = 0

    @property
    def is_open(self) -> bool:
        """Whether the window is there."""
        return self._window is not None and self._window.is_open

    def begin(self, env: ContactEnv[Any], moment: Moment) -> None:
        """Open a window on a new scene.

        Raises:
            RenderingUnavailableError: if there is no display.
        """
        self.close()
        self._env = env
        self._episode = moment.episode
        self._window = Window(env.model, "overview", self._press)
        self.show(moment)

    def show(self, moment: Moment) -> None:
        """Draw a moment of the same scene."""
        assert self._window is not None
        lines = [f"{name}: {value}" for name, value in describe(moment).items()]
        overlay = Overlay(moment.observation["desired_goal"], moment.plan)
        self._window.draw(self._env.data, overlay, "\n".join([*lines, "", KEYS]))

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.close()

    def _press(self, key: int) -> None:
        if key == SPACE:
            self._controls.play_or_pause()
        elif key == RIGHT:
            self._controls.single_step()
        elif key == ENTER:
            self._controls.go_to(self._episode + 1)
        elif key == BACKSPACE:
            self._controls.go_to(self._episode)
