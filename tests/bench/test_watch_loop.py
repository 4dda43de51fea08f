"""Who does what when; the clock is the test's."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from benchmarks.watch.controls import Controls
from benchmarks.watch.loop import IDLE_SECONDS, watch
from benchmarks.watch.session import Session
from tests.bench.watched import CABLE, Album, Faller, Still, spec


class Patient(Controls):
    """Waits for nothing, and remembers for how long it should have."""

    def __init__(self, *, playing: bool = True) -> None:
        super().__init__(playing=playing)
        self.waits: list[float] = []

    def wait(self, seconds: float) -> None:
        self.waits.append(round(seconds, 6))


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    opened = Session(spec(Still), CABLE)
    yield opened
    opened.close()


def ticking(seconds: float) -> Iterator[float]:
    """A clock that moves on at every look."""
    now = 0.0
    while True:
        yield now
        now += seconds


def run(session: Session, controls: Controls, looks: int, tick: float = 0.0) -> Album:
    album = Album(looks)
    watch(session, album, controls, first=5, clock=ticking(tick).__next__)
    return album


def test_every_step_is_shown_at_the_speed_asked_for(session: Session) -> None:
    for speed, pause in ((1.0, 0.05), (0.5, 0.1), (2.0, 0.025), (float("inf"), 0.0)):
        controls = Patient()
        controls.set_speed(speed)
        album = run(session, controls, 3)
        assert [moment.step for moment in album.moments] == [0, 1, 2, 3]
        assert album.scenes == [5]
        assert controls.waits == [pause] * 3


def test_time_that_a_step_took_is_not_waited_for_again(session: Session) -> None:
    controls = Patient()
    run(session, controls, 2, tick=0.03)  # one tick passes between start and end of a step
    assert controls.waits == [0.02, 0.02]


def test_pause_shows_nothing_new_and_a_single_step_does(session: Session) -> None:
    controls = Patient(playing=False)
    assert [m.step for m in run(session, controls, 3).moments] == [0]
    assert controls.waits == [IDLE_SECONDS] * 3
    controls.single_step()
    assert [m.step for m in run(session, controls, 3).moments] == [0, 1]


def test_other_episode_begins_at_once(session: Session) -> None:
    controls = Patient(playing=False)
    controls.go_to(7)
    album = run(session, controls, 2)
    assert album.scenes == [5, 7]
    assert [(m.episode, m.step) for m in album.moments] == [(5, 0), (7, 0)]


def test_ended_episode_stays_on_the_screen_until_another_is_asked_for() -> None:
    session = Session(spec(Faller), CABLE)
    controls = Patient()
    ended = run(session, controls, 8)
    assert [m.step for m in ended.moments] == [0, 1, 2, 2]
    assert ended.moments[-1].end.startswith("error")
    assert controls.waits[3:] == [IDLE_SECONDS] * 5
    session.close()


def test_closed_view_ends_the_watching(session: Session) -> None:
    assert [m.step for m in run(session, Patient(), 0).moments] == [0]
