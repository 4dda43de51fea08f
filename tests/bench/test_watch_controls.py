"""What a person may ask for, and how often it is granted."""

from __future__ import annotations

import threading
from time import perf_counter

from benchmarks.watch.controls import Controls


def test_playing_grants_every_step_and_pause_none() -> None:
    controls = Controls()
    assert controls.playing
    assert [controls.take_step() for _ in range(3)] == [True] * 3
    controls.play_or_pause()
    assert not controls.playing
    assert not controls.take_step()
    controls.play_or_pause()
    assert controls.take_step()


def test_single_step_pauses_and_is_granted_once() -> None:
    controls = Controls()
    controls.single_step()
    controls.single_step()
    assert not controls.playing
    assert [controls.take_step() for _ in range(4)] == [True, True, False, False]


def test_episode_is_handed_over_once_and_forgets_single_steps() -> None:
    controls = Controls(playing=False)
    assert controls.take_episode() is None
    controls.single_step()
    controls.go_to(3)
    controls.go_to(4)
    assert [controls.take_episode() for _ in range(2)] == [4, None]
    assert not controls.take_step()


def test_wait_ends_with_the_next_change() -> None:
    for change in (
        Controls.play_or_pause,
        Controls.single_step,
        lambda controls: controls.go_to(1),
        lambda controls: controls.set_speed(2.0),
    ):
        controls = Controls()
        threading.Timer(0.05, change, [controls]).start()
        start = perf_counter()
        controls.wait(60.0)
        assert perf_counter() - start < 30.0
        controls.wait(0.0)
        controls.wait(-1.0)
