"""What a worker process is doing, for its supervisor to see whatever becomes of the worker."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.context import BaseContext
from time import monotonic


class _Shared(ctypes.Structure):
    _fields_ = (
        ("deadline", ctypes.c_double),
        ("budget", ctypes.c_double),
        ("step", ctypes.c_int64),
        ("doing", ctypes.c_char * 64),
    )


class Pulse:
    """A few numbers in memory that a worker writes and its supervisor reads.

    Shared memory, not messages: it outlives a worker that was killed in the middle of a call.
    """

    def __init__(self, context: BaseContext | None = None) -> None:
        """Nothing is being done yet.

        Args:
            context: of the process to share with; None if this process watches itself.
        """
        shared = _Shared() if context is None else context.RawValue(_Shared)
        self._shared: _Shared = shared
        self.rest()

    def rest(self) -> None:
        """Between jobs."""
        self._shared.deadline = math.inf
        self._shared.budget = math.inf
        self._shared.step = 0
        self._shared.doing = b""

    @property
    def doing(self) -> str:
        """What is being done, in a few words; empty between jobs."""
        return str(self._shared.doing.decode(errors="replace"))

    @doing.setter
    def doing(self, words: str) -> None:
        self._shared.doing = words.encode()[:63]

    @property
    def step(self) -> int:
        """Control steps taken in this job."""
        return int(self._shared.step)

    @step.setter
    def step(self, step: int) -> None:
        self._shared.step = step

    @property
    def budget(self) -> float:
        """[s] that the present call may take."""
        return float(self._shared.budget)

    @property
    def overdue(self) -> bool:
        """Whether the present call has taken longer than that."""
        return monotonic() > float(self._shared.deadline)

    @contextmanager
    def limited(self, doing: str, seconds: float) -> Iterator[None]:
        """Do something that may take so long; whoever supervises kills the process after that.

        Args:
            doing: what, in a few words.
            seconds: [s] budget.
        """
        before = self.doing
        self.doing = doing
        self._shared.budget = seconds
        self._shared.deadline = monotonic() + seconds
        try:
            yield
        finally:
            self._shared.deadline = math.inf
        self.doing = before  # not after an exception: what failed stays readable
