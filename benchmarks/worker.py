"""One process that does jobs, and may hang or die without harm to its supervisor."""

from __future__ import annotations

import multiprocessing
import os
import secrets
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import monotonic
from typing import Final, Generic, NamedTuple, TypeVar

from benchmarks.pulse import Pulse

J = TypeVar("J")
R = TypeVar("R")

MATH_THREADS: Final = "OMP_NUM_THREADS"
"""OpenBLAS, MKL, OpenMP and PyTorch obey it. Results must not depend on the number of cores, and
workers must not compete for them."""

TICK: Final = 0.1
"""[s] between looks at the clock."""
_START_SECONDS: Final = 300.0
"""[s] that a process has to start; the time of a job counts from its beginning."""
_GRACE: Final = 2.0
"""[s] that a worker has to leave by itself."""


def maths_threads() -> str:
    """Threads for linear algebra: one, unless the user of this process says otherwise."""
    return os.environ.get(MATH_THREADS, "1")


class Done(NamedTuple, Generic[R]):
    """A job was done.

    Attributes:
        result: what came of it.
    """

    result: R


@dataclass(frozen=True)
class Loss:
    """A worker hung or died in a job.

    Attributes:
        doing: what it was doing, in a few words; empty if it had not begun.
        step: control steps it had taken.
        reason: how it was lost.
        seconds: [s] since it was given the job.
    """

    doing: str
    step: int
    reason: str
    seconds: float

    def __str__(self) -> str:
        """One line for a row."""
        return f"{self.doing}, step {self.step}: {self.reason}" if self.doing else self.reason


class Worker(Generic[J, R]):
    """A process of its own, with its own process group and folder for temporary files."""

    def __init__(
        self, do: Callable[[J, Pulse], R], job_seconds: float, group: str, maths: str
    ) -> None:
        """Start it.

        Args:
            do: picklable function of one job.
            job_seconds: [s] that one job may take.
            group: what its jobs have in common.
            maths: threads for linear algebra, from ``maths_threads``.
        """
        context = multiprocessing.get_context("spawn")
        self.group = group
        self._job_seconds = job_seconds
        self._given = 0.0
        self._began: float | None = None
        self._pulse = Pulse(context)
        self._folder = Path(tempfile.gettempdir(), f"icd-bench-{secrets.token_hex(8)}")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, do, self._pulse, self._folder))
        with _environment(MATH_THREADS, maths):
            self._process.start()
        theirs.close()

    def give(self, job: J) -> None:
        """Begin a job."""
        self._given, self._began = monotonic(), None
        with suppress(OSError):  # it died idle: ``outcome`` will say so
            self.connection.send(job)

    def result(self, job: J) -> Done[R] | Loss:
        """Do a job and wait for what becomes of it.

        Raises:
            Exception: what the job raised.
        """
        self.give(job)
        try:
            while (outcome := self.outcome()) is None:
                wait([self.connection], TICK)
        except BaseException:
            self.kill()
            raise
        return outcome

    def outcome(self) -> Done[R] | Loss | None:
        """What became of the job, or None while it is being done.

        Raises:
            Exception: what the job raised.
        """
        try:
            if self.connection.poll():
                return self._answer()
        except (EOFError, OSError):
            return self._lost(self._obituary())
        if not self._process.is_alive() and not self.connection.poll():
            return self._lost(self._obituary())
        if self._pulse.overdue:
            return self._lost(f"over its time budget of {self._pulse.budget:g} s")
        return self._out_of_time()

    def leave(self) -> None:
        """Let it end by itself, but not for long."""
        self.connection.close()
        self._process.join(_GRACE)
        self.kill()

    def kill(self) -> None:
        """End it and whatever it has started, now."""
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._pid, signal.SIGKILL)
        self._process.kill()
        self._process.join()
        self.connection.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    @property
    def _pid(self) -> int:
        assert self._process.pid is not None
        return self._process.pid

    def _answer(self) -> Done[R]:
        succeeded, answer = self.connection.recv()
        if not succeeded:
            raise answer
        return Done(answer)

    def _out_of_time(self) -> Loss | None:
        if self._began is None and self._pulse.doing:
            self._began = monotonic()
        if self._began is None:
            if monotonic() - self._given > _START_SECONDS:
                return self._lost(f"the process did not start within {_START_SECONDS:g} s")
        elif monotonic() - self._began > self._job_seconds:
            return self._lost(f"over its time budget of {self._job_seconds:g} s in all")
        return None

    def _lost(self, reason: str) -> Loss:
        seconds = monotonic() - self._given
        self.kill()
        return Loss(self._pulse.doing, self._pulse.step, reason, seconds)

    def _obituary(self) -> str:
        self._process.join(_GRACE)  # its pipe closes a moment before it is gone
        code = self._process.exitcode
        if code is None:
            return "worker closed its pipe"
        return f"worker died ({f'signal {-code}' if code < 0 else f'exit status {code}'})"


@contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    """Set a variable for processes that are started now."""
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


def _serve(connection: Connection, do: Callable[[J, Pulse], R], pulse: Pulse, folder: Path) -> None:
    """What the process does: jobs, until the pipe is closed."""
    tempfile.tempdir = str(folder)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # they are for the supervisor, which kills
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)  # so that whatever an agent starts dies with it
    with suppress(OSError):
        os.dup2(2, 1)  # stdout holds tables and JSON alone
    sys.stdout = sys.stderr
    threading.Thread(target=_end_with_parent, args=(folder,), daemon=True).start()
    with suppress(EOFError):
        while True:
            job = connection.recv()
            pulse.doing = "beginning"
            folder.mkdir(0o700, exist_ok=True)
            try:
                answer: tuple[bool, object] = (True, do(job, pulse))
            except Exception as error:
                answer = (False, error)
            with suppress(OSError):
                folder.rmdir()  # unless there is something in it: an idle worker may be killed
            pulse.rest()
            _send(connection, answer)
    shutil.rmtree(folder, ignore_errors=True)


def _send(connection: Connection, answer: tuple[bool, object]) -> None:
    try:
        connection.send(answer)
    except (TypeError, AttributeError, ValueError) as error:
        connection.send((False, RuntimeError(f"{answer[1]!r} cannot be sent: {error}")))


def _end_with_parent(folder: Path) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        shutil.rmtree(folder, ignore_errors=True)
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(os.getpid(), signal.SIGKILL)
        os._exit(1)
