"""A stand-in for MuJoCo's desktop viewer, for machines without a display."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

import mujoco
import mujoco.viewer
import numpy as np
import pytest

from icd_envs import window


class FakeViewer:
    """Remembers what it was shown; forces on the state what a real one might."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        mujoco.mj_forward(model, data)  # as the real one does
        self.model, self.data = model, data
        self.cam, self.opt = mujoco.MjvCamera(), mujoco.MjvOption()
        self.user_scn = mujoco.MjvScene(model, 10_000)
        self.shown: list[int] = []
        self.texts: list[str] = []
        self.running = True
        self.key: Callable[[int], None] | None = None
        self._lock = threading.Lock()

    def lock(self) -> AbstractContextManager[bool]:
        return self._lock

    def is_running(self) -> bool:
        return self.running

    def set_texts(self, texts: tuple[object, object, str, str]) -> None:
        self.texts.append(texts[2])

    def sync(self) -> None:
        assert not self._lock.locked()
        self.shown.append(self.user_scn.ngeom)
        self.data.xfrc_applied[:] = 7.0  # a person drags the object

    def close(self) -> None:
        self.running = False

    def colours(self) -> np.ndarray:
        """(G, 4) of what is drawn on top now."""
        return np.array([g.rgba for g in self.user_scn.geoms[: self.user_scn.ngeom]]).reshape(-1, 4)


def install(monkeypatch: pytest.MonkeyPatch) -> list[FakeViewer]:
    """Let every window be a fake one; they are listed as they open."""
    opened: list[FakeViewer] = []

    def launch(
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        key_callback: Callable[[int], None] | None,
        show_left_ui: bool,
        show_right_ui: bool,
    ) -> FakeViewer:
        opened.append(FakeViewer(model, data))
        opened[-1].key = key_callback
        return opened[-1]

    monkeypatch.setattr(window, "check_display", lambda: None)
    monkeypatch.setattr(mujoco.viewer, "launch_passive", launch)
    return opened
