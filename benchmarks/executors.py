"""Who does the jobs: this process, worker processes of this machine, or a cluster."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from multiprocessing.connection import wait
from typing import Final, Generic, NamedTuple, Protocol, TypeVar

from benchmarks.errors import WorkerStartError
from benchmarks.provenance import cpu_count
from benchmarks.pulse import Pulse
from benchmarks.worker import TICK, Loss, Worker, maths_threads
from icd_envs.errors import InvalidOptionError, unknown_name

J = TypeVar("J")
R = TypeVar("R")

EXECUTORS: Final = ("local", "ray")

_STRIDE: Final = 8
"""Jobs of one group that a worker may do before those of the others; see ``_next``."""
STARTS: Final = 3
"""Workers that may die before their first job, one after the other."""


class Retry(NamedTuple, Generic[J]):
    """Try this instead of a job that was lost.

    Attributes:
        job: what to do.
    """

    job: J


def _one_group(job: object) -> str:
    return ""


@dataclass(frozen=True)
class Work(Generic[J, R]):
    """What is done with jobs; the same whoever does it.

    Attributes:
        do: picklable function of a job and the worker's pulse; what it raises ends the run.
        lost: what becomes of a job whose worker hung or died: a result, or another attempt.
        group: jobs of different groups never share a process.
        seconds: [s] that one job may take.
    """

    do: Callable[[J, Pulse], R]
    lost: Callable[[J, Loss], R | Retry[J]]
    group: Callable[[J], str] = _one_group
    seconds: float = math.inf


class Executor(Protocol):
    """Does jobs; results, and nothing else, must not depend on which one it is."""

    @property
    def threads(self) -> int:
        """Threads that one job may use."""
        ...

    def execute(self, work: Work[J, R], jobs: Sequence[J]) -> Generator[R, None, None]:
        """Yield the result of every job, in the order of completion; close it to stop early."""
        ...


@dataclass(frozen=True)
class InProcess:
    """One job after another in this process, for debuggers: nothing is limited or survived.

    Attributes:
        threads_each: threads that one job may use; None is all cores.
    """

    threads_each: int | None = None

    @property
    def threads(self) -> int:
        """All cores, unless it was given."""
        return self.threads_each or cpu_count()

    def execute(self, work: Work[J, R], jobs: Sequence[J]) -> Generator[R, None, None]:
        """Yield the result of every job, in their order."""
        pulse = Pulse()
        for job in jobs:
            yield work.do(job, pulse)
            pulse.rest()


@dataclass(frozen=True)
class Local:
    """Worker processes of this machine, each watched and replaced when it hangs or dies.

    Attributes:
        workers: processes at a time.
        threads_each: threads that one job may use; None shares the cores.
    """

    workers: int = 1
    threads_each: int | None = None

    @property
    def threads(self) -> int:
        """Cores over workers, unless it was given."""
        return self.threads_each or max(1, cpu_count() // self.workers)

    def execute(self, work: Work[J, R], jobs: Sequence[J]) -> Generator[R, None, None]:
        """Yield the result of every job, in the order of completion.

        Raises:
            WorkerStartError: processes die before they can begin a job.
        """
        crew = _Crew(work, jobs, self.workers)
        try:
            yield from crew.results()
            crew.leave()
        finally:
            crew.kill()  # results are written by this process only


class _Crew(Generic[J, R]):
    """Workers and what they are doing."""

    def __init__(self, work: Work[J, R], jobs: Sequence[J], size: int) -> None:
        self._work = work
        self._waiting = deque(jobs)
        self._window = _STRIDE * len({work.group(job) for job in jobs})
        self._size = size
        self._workers: list[Worker[J, R]] = []
        self._doing: dict[Worker[J, R], J] = {}
        self._false_starts = 0

    def results(self) -> Iterator[R]:
        while self._waiting or self._doing:
            self._hand_out()
            wait([worker.connection for worker in self._doing], timeout=TICK)
            for worker in list(self._doing):
                outcome = worker.outcome()
                if outcome is None:
                    continue
                job = self._doing.pop(worker)
                if not isinstance(outcome, Loss):
                    self._false_starts = 0
                    yield outcome.result
                    continue
                self._workers.remove(worker)
                after = self._after(job, outcome)
                if isinstance(after, Retry):
                    self._waiting.appendleft(after.job)
                else:
                    yield after

    def leave(self) -> None:
        while self._workers:
            self._workers.pop().leave()

    def kill(self) -> None:
        while self._workers:
            self._workers.pop().kill()

    def _hand_out(self) -> None:
        """Give every idle worker a job, and fill the crew up."""
        for worker in [worker for worker in self._workers if worker not in self._doing]:
            if not self._waiting:
                return
            if not self._give(worker, worker.group):
                self._workers.remove(worker)
                worker.leave()
        while self._waiting and len(self._workers) < self._size:
            group = self._work.group(self._waiting[0])
            fresh = Worker[J, R](self._work.do, self._work.seconds, group, maths_threads())
            self._workers.append(fresh)
            self._give(fresh, group)

    def _give(self, worker: Worker[J, R], group: str) -> bool:
        """Give a worker a job of its group, if one of the next jobs is of that group.

        Only the next few count: groups take turns, so that what is there after an interrupt
        compares like with like; and a worker keeps to its group for some time, because another
        one means another process.
        """
        for place, job in enumerate(islice(self._waiting, self._window)):
            if self._work.group(job) == group:
                del self._waiting[place]
                worker.give(job)
                self._doing[worker] = job
                return True
        return False

    def _after(self, job: J, loss: Loss) -> R | Retry[J]:
        if loss.doing:
            self._false_starts = 0
            return self._work.lost(job, loss)
        self._false_starts += 1
        if self._false_starts == STARTS:
            raise WorkerStartError(
                f"{STARTS} worker processes ended before their first job, the last because: "
                f"{loss.reason}: see what they printed; a script of yours that starts a run needs "
                "`if __name__ == '__main__':`"
            )
        return Retry(job)


def make_executor(
    name: str, *, workers: int | None, threads: int | None, address: str | None
) -> Executor:
    """Make the executor of that name.

    Args:
        name: "local" or "ray".
        workers: jobs at a time; 0 does everything in this process; None is 1 here, and on a
            cluster as many as fit.
        threads: threads that one job may use; None shares the cores, and is 1 on a cluster.
        address: of the cluster; None is a new one on this machine.

    Raises:
        InvalidOptionError: unknown name, an option that does not fit it, or Ray is missing.
    """
    if name not in EXECUTORS:
        raise InvalidOptionError(unknown_name("executor", name, EXECUTORS))
    if name == "ray":
        from benchmarks.ray_executor import Ray

        return Ray(address, workers, threads or 1)
    if address is not None:
        raise InvalidOptionError(f"address={address!r} needs a cluster: --executor ray")
    return InProcess(threads) if workers == 0 else Local(workers or 1, threads)
