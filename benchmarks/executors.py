"""Do jobs one after another here, or in worker processes that may die without harm."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

J = TypeVar("J")
R = TypeVar("R")


def execute(
    work: Callable[[J], R], jobs: Sequence[J], workers: int, lost: Callable[[J], R]
) -> Generator[R, None, None]:
    """Yield the result of every job, in the order of completion.

    With one worker everything happens in this process, so that a debugger and ctrl-C work. When a
    worker process dies, the jobs in flight are repeated one by one, each alone; the one that kills
    its worker again is ``lost``, the others are unaffected. Close the generator to stop early.

    Args:
        work: picklable function of one job; must not raise.
        jobs: what to do.
        workers: processes, >= 1.
        lost: result of a job whose worker died twice.
    """
    if workers == 1:
        yield from map(work, jobs)
        return
    waiting = deque(jobs)
    while waiting:
        suspects = yield from _until_broken(work, waiting, workers)
        for suspect in suspects:
            if (yield from _until_broken(work, deque([suspect]), 1)):
                yield lost(suspect)


def _until_broken(
    work: Callable[[J], R], waiting: deque[J], workers: int
) -> Generator[R, None, list[J]]:
    """Yield results until nothing waits or a worker dies; return the jobs that died with it."""
    running: dict[Future[R], J] = {}
    with _pool(workers) as pool:
        while waiting or running:
            while waiting and len(running) < workers:
                try:
                    running[pool.submit(work, waiting[0])] = waiting[0]
                except BrokenProcessPool:
                    if not running:
                        return []
                    break
                waiting.popleft()
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            broken = [job for future, job in running.items() if _died(future)]
            for future in done:
                if not _died(future):
                    del running[future]
                    yield future.result()
            if broken:
                wait(running)
                yield from (future.result() for future in running if not _died(future))
                return [job for future, job in running.items() if _died(future)]
    return []


def _died(future: Future[R]) -> bool:
    return future.done() and isinstance(future.exception(), BrokenProcessPool)


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        workers, mp_context=multiprocessing.get_context("spawn"), initializer=_begin_worker
    )
    try:
        yield pool
    except BaseException:
        # Interrupted: results are written by this process only, so workers may be killed.
        for child in set(multiprocessing.active_children()) - others:
            child.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin_worker() -> None:
    """Leave ctrl-C and stdout to the parent, and do not outlive it."""
    sys.stdout = sys.stderr
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
