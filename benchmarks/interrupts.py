"""Ctrl-C and termination: stop in good order the first time, at once the second."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final

_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


class Interrupt:
    """Whether a signal came.

    Attributes:
        number: of the signal, 0 if none came.
    """

    number = 0

    @property
    def exit_code(self) -> int:
        """What a shell expects: 130 after SIGINT, 143 after SIGTERM."""
        return 128 + self.number


@contextmanager
def interruptible() -> Iterator[Interrupt]:
    """Leave the block when SIGINT or SIGTERM comes, without an exception.

    Where a signal is ignored, as SIGINT is in background jobs, it stays ignored.
    """
    interrupt = Interrupt()

    def stop(number: int, frame: FrameType | None) -> None:
        if interrupt.number:
            os._exit(128 + number)
        interrupt.number = number
        raise KeyboardInterrupt

    heard = [number for number in _SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, stop) for number in heard}
    try:
        yield interrupt
    except KeyboardInterrupt:
        if not interrupt.number:
            raise
    finally:
        if not interrupt.number:
            for number, handler in before.items():
                signal.signal(number, handler)
