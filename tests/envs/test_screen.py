"""The render modes, without OpenGL."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from icd_envs import screen
from icd_envs.api import PlanView
from icd_envs.drawing import CURRENT_RGBA, GOAL_RGBA, Overlay
from icd_envs.errors import RenderingUnavailableError
from tests.envs import fake_viewer
from tests.envs.making import make


class FakeRenderer:
    """Returns what it was asked to draw."""

    made = 0

    def __init__(self, model: object, width: int, height: int, camera: str) -> None:
        type(self).made += 1
        self.asked = (width, height, camera)
        self.closed = False

    def rgb(self, data: object, overlay: Overlay) -> Overlay:
        return overlay

    def depth(self, data: object) -> tuple[int, int, str]:
        return self.asked

    def close(self) -> None:
        self.closed = True


@pytest.fixture(autouse=True)
def _fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(screen, "SceneRenderer", FakeRenderer)
    monkeypatch.setattr(FakeRenderer, "made", 0)


def test_plan_is_in_pictures_until_the_next_one_or_reset() -> None:
    env = make(render_mode="rgb_array")
    env.reset(seed=0)
    plan = PlanView(status="mine")
    env.show_plan(plan)
    env.step(np.zeros(3))
    assert env.render().plan is plan  # type: ignore[union-attr]
    env.show_plan(None)
    assert env.render().plan is None  # type: ignore[union-attr]
    env.show_plan(plan)
    observation, _ = env.reset(seed=0)
    overlay: Any = env.render()
    assert overlay.plan is None
    np.testing.assert_array_equal(overlay.goal, observation["desired_goal"])
    assert FakeRenderer.made == 2  # one for each scene
    env.close()


def test_depth_has_the_size_and_camera_asked_for() -> None:
    env = make(render_mode="depth_array", width=64, height=48, camera="top")
    env.reset(seed=0)
    assert env.render() == (64, 48, "top")
    env.close()


def test_person_sees_every_reset_and_step(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = fake_viewer.install(monkeypatch)
    env = make(render_mode="human")
    env.reset(seed=0)
    env.step(np.zeros(3))
    env.show_plan(PlanView(subgoals=np.ones((1, 30, 3))))
    env.step(np.zeros(3))
    assert env.render() is None
    (first,) = opened
    assert first.shown == [200, 200, 210, 210]
    assert (first.colours()[:200] == np.float32(GOAL_RGBA)).all()
    assert (first.colours()[200:] == np.float32(CURRENT_RGBA)).all()
    env.reset(seed=1)
    assert [viewer.running for viewer in opened] == [False, True]
    assert opened[1].shown == [200]
    env.close()
    assert not opened[1].running


@pytest.mark.parametrize("mode", ["rgb_array", "human"])
def test_copy_opens_its_own(monkeypatch: pytest.MonkeyPatch, mode: str) -> None:
    fake_viewer.install(monkeypatch)
    env = make(render_mode=mode)
    env.reset(seed=0)
    env.render()
    opened = env._screen._renderer or env._screen._window
    other = copy.deepcopy(env)
    other.render()
    assert opened is not None
    assert (env._screen._renderer or env._screen._window) is opened
    assert (other._screen._renderer or other._screen._window) is not opened
    other.close()
    env.close()


def test_without_a_display_a_person_is_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("icd_envs.window.has_display", lambda: False)
    env = make(render_mode="human")
    with pytest.raises(RenderingUnavailableError, match="DISPLAY"):
        env.reset(seed=0)
    with pytest.raises(RenderingUnavailableError, match="DISPLAY"):
        env.render()
    env.close()
