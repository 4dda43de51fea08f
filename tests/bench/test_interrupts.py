"""Signals, to this very process."""

import os
import signal
from collections.abc import Iterator

import pytest

from benchmarks.interrupts import interruptible


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """Put back what was there."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_first_signal_leaves_the_block_and_the_second_the_program(
    number: int, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = []
    monkeypatch.setattr(os, "_exit", ended.append)
    with interruptible() as interrupt:
        os.kill(os.getpid(), number)
        raise AssertionError("the block goes on")
    assert (interrupt.number, interrupt.exit_code, ended) == (number, code, [])
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), number)
    assert ended == [code]


def test_without_a_signal_everything_is_as_before() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with interruptible() as interrupt:
        assert signal.getsignal(signal.SIGTERM) != before
    assert interrupt.number == 0
    assert signal.getsignal(signal.SIGTERM) == before


def test_ignored_signal_stays_ignored_and_a_foreign_interrupt_passes() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with interruptible() as interrupt:
        os.kill(os.getpid(), signal.SIGINT)
    assert interrupt.number == 0
    with pytest.raises(KeyboardInterrupt), interruptible():
        raise KeyboardInterrupt
