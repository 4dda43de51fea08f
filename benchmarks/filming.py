"""A video of one episode; whatever goes wrong with it leaves the episode as it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium as gym

from benchmarks.attempt import RENDERING
from benchmarks.conditions import TaskSpec
from benchmarks.pulse import Pulse
from icd_envs.wrappers import RecordEpisodes

Env = gym.Env[Any, Any]


def in_pictures(task: TaskSpec) -> TaskSpec:
    """The same task, drawn."""
    options = (*task.condition.options, ("render_mode", "rgb_array"))
    return replace(task, condition=replace(task.condition, options=options))


class Camera:
    """Records one episode."""

    def __init__(self, pulse: Pulse, render_seconds: float) -> None:
        """Nothing is recorded yet.

        Args:
            pulse: is told when a picture is drawn.
            render_seconds: [s] that one may take.
        """
        self._pulse, self._seconds = pulse, render_seconds
        self._folder = TemporaryDirectory("", "video-", ignore_cleanup_errors=True)
        self._recorder: RecordEpisodes | None = None

    def watch(self, env: Env) -> Env:
        """The same environment, recorded; closing what is returned leaves ``env`` open.

        Args:
            env: made from ``in_pictures``.

        Raises:
            InvalidOptionError: it draws no pictures.
        """
        watched = _WatchedPictures(env, self._pulse, self._seconds)
        self._recorder = RecordEpisodes(watched, self._folder.name)
        return self._recorder

    def develop(self) -> bytes:
        """End the recording and return the file's content, empty if there is none."""
        if self._recorder is not None:
            self._recorder.close()
        content = b"".join(file.read_bytes() for file in Path(self._folder.name).glob("*.mp4"))
        self._folder.cleanup()
        return content


class _WatchedPictures(gym.Wrapper[Any, Any, Any, Any]):
    """A renderer that hangs must not hang the run."""

    def __init__(self, env: Env, pulse: Pulse, seconds: float) -> None:
        super().__init__(env)
        self._pulse, self._seconds = pulse, seconds

    def render(self) -> Any:  # noqa: ANN401  Gymnasium's own
        with self._pulse.limited(RENDERING, self._seconds):
            return super().render()

    def close(self) -> None:
        """Leave the environment to whoever made it."""
