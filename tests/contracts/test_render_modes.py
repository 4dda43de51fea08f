"""Pictures, depth and the window, of every environment."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.passive_env_checker import env_render_passive_checker

from icd_envs.api import PlanView
from icd_envs.drawing import OBJECT_RGBA
from icd_envs.errors import RenderingUnavailableError
from icd_envs.screen import RENDER_MODES
from icd_envs.tasks.env import ContactEnv
from tests.envs import fake_viewer
from tests.envs.making import bare, digest, play, random_actions, remake

YELLOW = tuple(round(255 * part) for part in OBJECT_RGBA[:3])
RED = (217, 26, 26)
SEEN = 8
"""Pixels of a colour, at least, if it is in a picture."""


@pytest.fixture(scope="module")
def pictured(env: ContactEnv[Any]) -> Iterator[ContactEnv[Any]]:
    """The same environment, drawn; skips where there is no OpenGL."""
    drawn = bare(remake(env, render_mode="rgb_array", width=240, height=180))
    drawn.reset(seed=0)
    try:
        drawn.render()
    except RenderingUnavailableError as error:
        pytest.skip(str(error))
    yield drawn
    drawn.close()


def render(env: ContactEnv[Any]) -> np.ndarray:
    """A picture that Gymnasium finds nothing wrong with."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return np.asarray(env_render_passive_checker(env))


def count(picture: np.ndarray, rgb: tuple[int, ...]) -> int:
    """Pixels that have about the hue of a colour."""
    pixels = picture.astype(float) + 1.0
    hue = pixels / pixels.max(axis=-1, keepdims=True)
    wanted = (np.array(rgb) + 1.0) / (max(rgb) + 1.0)
    alike = (np.abs(hue - wanted).max(axis=-1) < 0.2) & (pixels.max(axis=-1) > 60)
    return int(np.count_nonzero(alike))


def test_every_mode_is_declared_and_accepted(env: ContactEnv[Any]) -> None:
    assert tuple(env.metadata["render_modes"]) == RENDER_MODES
    for mode in RENDER_MODES:
        made = remake(env, render_mode=mode)
        assert made.render_mode == mode
        made.close()


def test_object_is_yellow_goal_red_and_subgoals_blue(pictured: ContactEnv[Any]) -> None:
    cloud = pictured.step(np.zeros(3))[0]["desired_goal"] + np.float32([0.0, 0.0, 0.15])
    pictured.show_plan(None)
    plain = render(pictured)
    assert (plain.shape, plain.dtype) == ((180, 240, 3), np.uint8)
    assert [count(plain, colour) > SEEN for colour in (YELLOW, RED)] == [True, True]
    pictured.show_plan(PlanView(subgoals=cloud[None]))
    planned = render(pictured)
    bluer = np.diff(planned[..., ::2].astype(int)) - np.diff(plain[..., ::2].astype(int))
    assert np.count_nonzero(bluer > 20) > SEEN
    assert bluer.min() > -20
    assert [count(planned, colour) > SEEN for colour in (YELLOW, RED)] == [True, True]


def test_window_changes_no_bit_of_what_follows(
    env: ContactEnv[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_viewer.install(monkeypatch)
    actions = random_actions(14, 4)
    expected = digest([env.reset(seed=2)[0], *play(env, actions)])
    watched = bare(remake(env, render_mode="human"))
    assert digest([watched.reset(seed=2)[0], *play(watched, actions)]) == expected
    assert render(watched) == np.array(None)
    watched.close()


def test_depth_shows_the_scene_and_nothing_drawn_on_top(pictured: ContactEnv[Any]) -> None:
    deep = bare(remake(pictured, render_mode="depth_array"))
    deep.reset(seed=0)
    before = render(deep)
    assert (before.shape, before.dtype) == ((180, 240), np.float32)
    assert 0.1 < before.min() < before.max()
    deep.show_plan(PlanView(subgoals=np.full((1, 30, 3), 0.2)))
    np.testing.assert_array_equal(before, deep.render())
    deep.close()


def test_gymnasium_records_a_video(pictured: ContactEnv[Any], tmp_path: Path) -> None:
    import imageio.v3 as iio

    recorded = gym.wrappers.RecordVideo(
        remake(pictured, render_mode="rgb_array"), str(tmp_path / "videos")
    )
    recorded.reset(seed=0)
    for action in random_actions(15, 4):
        recorded.step(action)
    recorded.close()
    (file,) = (tmp_path / "videos").iterdir()
    video = iio.imread(file)
    assert video.shape[1:] == (180, 240, 3)
    assert 4 <= len(video) <= 5  # MoviePy rounds
    assert video.std(axis=(1, 2)).min() > 5  # and it is no empty picture
    assert iio.immeta(file)["fps"] == recorded.metadata["render_fps"] == 20
