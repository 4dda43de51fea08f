"""The desktop view, on a fake window."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from benchmarks.watch.controls import Controls
from benchmarks.watch.desktop import BACKSPACE, ENTER, RIGHT, SPACE, DesktopView
from benchmarks.watch.loop import watch
from benchmarks.watch.session import Session
from tests.bench.watched import CABLE, Dreamer, spec
from tests.envs import fake_viewer
from tests.envs.fake_viewer import FakeViewer


@pytest.fixture
def viewers(monkeypatch: pytest.MonkeyPatch) -> list[FakeViewer]:
    return fake_viewer.install(monkeypatch)


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    opened = Session(spec(Dreamer), CABLE)
    yield opened
    opened.close()


def test_goal_plan_and_text_are_in_the_window(viewers: list[FakeViewer], session: Session) -> None:
    view = DesktopView(Controls())
    assert not view.is_open
    view.begin(session.env, session.begin(0))
    assert view.is_open
    view.show(session.advance())
    (viewer,) = viewers
    # The goal; two subgoals ahead, one of three points each; two paths of ten points.
    assert viewer.shown == [200, 200 + 2 * 67 + 2 * 9]
    assert "step: 1 of 300\n" in viewer.texts[-1]
    assert "plan: dreaming\n" in viewer.texts[-1]
    assert "space: play or pause" in viewer.texts[-1]
    view.close()
    view.close()
    assert not view.is_open


def test_keys_operate_the_controls(viewers: list[FakeViewer], session: Session) -> None:
    controls = Controls()
    view = DesktopView(controls)
    view.begin(session.env, session.begin(4))
    press = viewers[0].key
    assert press is not None
    press(SPACE)
    assert not controls.playing
    press(RIGHT)
    assert controls.take_step()
    press(ENTER)
    assert controls.take_episode() == 5
    press(BACKSPACE)
    assert controls.take_episode() == 4
    press(ord("Q"))
    assert (controls.playing, controls.take_step(), controls.take_episode()) == (False, False, None)
    view.close()


def test_closing_the_window_ends_the_watching(viewers: list[FakeViewer], session: Session) -> None:
    class Impatient(Controls):
        def wait(self, seconds: float) -> None:
            viewers[0].running = len(viewers[0].shown) < 3

    watch(session, DesktopView(Impatient()), Impatient())
    assert len(viewers[0].shown) == 3
