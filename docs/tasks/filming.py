"""Frames of an episode and where they are kept: shared by what draws pictures of the tasks."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple

import gymnasium as gym
import numpy as np
from PIL import Image

import icd_envs  # noqa: F401  registers the environments
from benchmarks.gif import Frame, shrunk
from icd_envs.api import SimState
from icd_envs.screen import CAMERAS

FOLDER: Final = Path(__file__).parent / "img"
WIDTH: Final = 480
HEIGHT: Final = 360
"""[px] of a frame."""


class Film(NamedTuple):
    """One episode, seen by the camera ``overview``.

    Attributes:
        frames: (360, 480, 3) each, at the start and after every step.
        end: the last state.
        info: of the last step.
    """

    frames: list[Frame]
    end: SimState
    info: dict[str, Any]


def film_expert(env_id: str, seed: int) -> Film:
    """The clean expert in a test scene, from the start until success has held."""
    env = _make(env_id, CAMERAS[0])
    _, info = env.reset(seed=seed)
    oracle = env.unwrapped.episode(oracle=True).oracle  # type: ignore[attr-defined]
    frames: list[Any] = [env.render()]
    for action in oracle.actions:
        *_, info = env.step(action)
        frames.append(env.render())
    end = env.unwrapped.snapshot()  # type: ignore[attr-defined]
    env.close()
    return Film(frames, end, info)


def all_views(env_id: str, seed: int, state: SimState) -> Frame:
    """(240, 960, 3) a state of an episode from every camera, side by side."""
    views: list[Any] = []
    for camera in CAMERAS:
        env = _make(env_id, camera)
        env.reset(seed=seed)
        env.unwrapped.restore(state)  # type: ignore[attr-defined]
        views.append(env.render())
        env.close()
    return np.concatenate([shrunk(view, 320) for view in views], axis=1)


def save(name: str, picture: Frame) -> None:
    """Write ``docs/tasks/img/<name>.png``."""
    Image.fromarray(picture).save(FOLDER / f"{name}.png", optimize=True)


def _make(env_id: str, camera: str) -> gym.Env[Any, Any]:
    return gym.make(
        env_id, split="test", render_mode="rgb_array", width=WIDTH, height=HEIGHT, camera=camera
    )
