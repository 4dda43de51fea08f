"""What a supervisor sees of a worker."""

import multiprocessing

import pytest

from benchmarks.pulse import Pulse


def test_what_is_done_and_for_how_long_can_be_read(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr("benchmarks.pulse.monotonic", lambda: now)
    pulse = Pulse()
    assert (pulse.doing, pulse.step, pulse.overdue) == ("", 0, False)
    pulse.doing, pulse.step = "resetting", 3
    with pulse.limited("act", 2.5):
        assert (pulse.doing, pulse.budget, pulse.overdue) == ("act", 2.5, False)
        now += 2.5
        assert not pulse.overdue
        now += 0.001
        assert pulse.overdue
    assert (pulse.doing, pulse.step, pulse.overdue) == ("resetting", 3, False)
    pulse.rest()
    assert (pulse.doing, pulse.step) == ("", 0)


def test_what_failed_stays_readable_but_no_longer_runs_out_of_time() -> None:
    pulse = Pulse()
    with pytest.raises(ZeroDivisionError), pulse.limited("act", 0.0):
        raise ZeroDivisionError
    assert (pulse.doing, pulse.overdue) == ("act", False)


def test_long_words_are_cut() -> None:
    pulse = Pulse()
    pulse.doing = "ä" * 100
    assert pulse.doing.startswith("ä" * 31)


def tell(pulse: Pulse) -> None:
    pulse.doing, pulse.step = "act", 7


def test_another_process_writes_what_this_one_reads() -> None:
    context = multiprocessing.get_context("spawn")
    pulse = Pulse(context)
    process = context.Process(target=tell, args=(pulse,))
    process.start()
    process.join(60.0)
    assert (pulse.doing, pulse.step) == ("act", 7)
