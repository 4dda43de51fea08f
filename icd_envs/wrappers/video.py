"""Videos of episodes, written with imageio.

Gymnasium's own ``RecordVideo`` works as well; it needs MoviePy, which asks for an older Pillow.
An agent's plan is in the frames if the environment was told of it: ``env.unwrapped.show_plan``.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium as gym

from icd_envs.api import FloatArray
from icd_envs.errors import InvalidOptionError, RenderingUnavailableError


def check_imageio() -> None:
    """Make sure that videos can be written.

    Raises:
        InvalidOptionError: imageio or its ffmpeg is not installed.
    """
    if find_spec("imageio") is None or find_spec("imageio_ffmpeg") is None:
        raise InvalidOptionError(
            "videos need imageio: pip install 'implicit-contact-diffuser[video]'"
        )


class RecordEpisodes(
    gym.Wrapper[Any, FloatArray, Any, FloatArray], gym.utils.RecordConstructorArgs
):
    """Write one mp4 file per episode; where pictures are impossible, warn once and go on."""

    def __init__(
        self, env: gym.Env[Any, Any], folder: str, *, name: str = "episode", every: int = 1
    ) -> None:
        """Prepare; nothing is written before the first step.

        Args:
            env: made with ``render_mode="rgb_array"``.
            folder: where the files go; made if needed.
            name: files are called ``<name>-0000.mp4`` and so on, counting all episodes.
            every: record one episode in that many.

        Raises:
            InvalidOptionError: if ``env`` draws no pictures, ``every`` is below 1, or imageio is
                missing.
        """
        gym.utils.RecordConstructorArgs.__init__(self, folder=folder, name=name, every=every)
        super().__init__(env)
        if env.render_mode != "rgb_array":
            raise InvalidOptionError(
                f"render_mode must be 'rgb_array' for a video, got {env.render_mode!r}: "
                "make(..., render_mode='rgb_array')"
            )
        if every < 1:
            raise InvalidOptionError(f"every must be at least 1, got {every}")
        check_imageio()
        self._folder, self._name, self._every = Path(folder), name, every
        self._episodes = 0
        self._works = True
        self._path = self._folder
        self._writer: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Finish the video of the last episode, if it did not end, and begin the next."""
        self._finish()
        result = super().reset(seed=seed, options=options)
        if self._episodes % self._every == 0 and self._works:
            self._begin()
        self._episodes += 1
        return result

    def step(self, action: FloatArray) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step and add a frame; the file is complete when the episode has ended."""
        result = super().step(action)
        self._add_frame()
        if result[2] or result[3]:
            self._finish()
        return result

    def close(self) -> None:
        """Finish the video and close the environment."""
        self._finish()
        super().close()

    def _begin(self) -> None:
        import imageio

        self._path = self._folder / f"{self._name}-{self._episodes:04d}.mp4"
        fps = self.metadata["render_fps"]
        with self._harmless():
            self._folder.mkdir(parents=True, exist_ok=True)
            self._writer = imageio.get_writer(self._path, fps=fps, macro_block_size=2)
        self._add_frame()

    def _add_frame(self) -> None:
        if self._writer is not None:
            with self._harmless():
                self._writer.append_data(self.env.render())

    def _finish(self) -> None:
        if self._writer is not None:
            with self._harmless():
                self._writer.close()
            self._writer = None

    @contextmanager
    def _harmless(self) -> Iterator[None]:
        """A broken OpenGL, a missing ffmpeg or a full disk must not change what is recorded."""
        try:
            yield
        except (RenderingUnavailableError, OSError, RuntimeError) as error:
            self._works = False
            self._writer = None
            with suppress(OSError):
                self._path.unlink(missing_ok=True)  # half a file cannot be played
            warnings.warn(f"no videos: {error}", stacklevel=4)
