"""Jobs on a Ray cluster: the same supervised processes, on whatever node has cores to spare.

A node that dies takes nothing with it: Ray gives its jobs to others. All nodes need this project
in the same version; results are written by the process that started the run only.
"""

from __future__ import annotations

import os
import platform
import secrets
import signal
import socket
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, Generic, NamedTuple, TypeVar

from benchmarks.errors import IncompatibleResultsError
from benchmarks.executors import STARTS, Retry, Work
from benchmarks.provenance import code_fingerprint, package_versions
from benchmarks.pulse import Pulse
from benchmarks.worker import Done, Loss, Worker, maths_threads
from icd_envs.errors import InvalidOptionError

J = TypeVar("J")
R = TypeVar("R")

_RETRIES: Final = 3
"""How often a job goes to another node because its node died."""
_ANSWER_SECONDS: Final = 10.0
_KEPT: Final = 4
"""Groups of which a Ray process keeps a worker."""


@dataclass(frozen=True)
class Ray:
    """Worker processes on the nodes of a cluster.

    Attributes:
        address: of the cluster, ``host:port`` or ``auto``; None starts one on this machine.
        workers: jobs at a time; None is as many as the cluster has cores for.
        threads: cores of one job.
    """

    address: str | None = None
    workers: int | None = None
    threads: int = 1

    def __post_init__(self) -> None:
        """Refuse what cannot work."""
        if find_spec("ray") is None:
            raise InvalidOptionError(
                "Ray is not installed: pip install 'implicit-contact-diffuser[ray]'"
            )
        if self.workers == 0:
            raise InvalidOptionError("workers=0, for debuggers, needs --executor local")

    def execute(self, work: Work[J, R], jobs: Sequence[J]) -> Generator[R, None, None]:
        """Yield the result of every job, in the order of completion.

        Raises:
            IncompatibleResultsError: a node has another version of this project or a library.
            InvalidOptionError: there is no cluster at the address.
        """
        if not jobs:
            return
        with _connected(self.address) as ray:
            cores = int(ray.cluster_resources().get("CPU", 1))
            limit = self.workers or max(1, cores // self.threads)
            remote = ray.remote(num_cpus=self.threads, max_retries=_RETRIES)(_do)
            order = ray.put(_Order(secrets.token_hex(8), work.do, work.seconds, _here()))
            waiting = deque(jobs)
            running: dict[Any, J] = {}
            try:
                while waiting or running:
                    while waiting and len(running) < limit:
                        job = waiting.popleft()
                        running[remote.remote(order, work.group(job), job)] = job
                    for done in ray.wait(list(running), timeout=1.0)[0]:
                        job = running.pop(done)
                        outcome: Done[R] | Loss = _outcome(ray, done)
                        after = work.lost(job, outcome) if isinstance(outcome, Loss) else outcome[0]
                        if isinstance(after, Retry):
                            waiting.appendleft(after.job)
                        else:
                            yield after
            finally:
                for reference in running:
                    ray.cancel(reference)  # by force, Ray 2.60 aborts if one is just being done


class _Place(NamedTuple):
    """What a node must have in common with the process that started the run."""

    folder: str
    path: list[str]
    maths: str
    code: str
    packages: dict[str, str]


class _Order(NamedTuple, Generic[J, R]):
    """What is the same for all jobs."""

    token: str
    do: Callable[[J, Pulse], R]
    seconds: float
    place: _Place


def _here() -> _Place:
    return _Place(os.getcwd(), sys.path, maths_threads(), code_fingerprint(), package_versions())


_workers: dict[tuple[str, str], Worker[Any, Any]] = {}
"""Those of this Ray process, the least recently used first."""


def _do(order: _Order[J, R], group: str, job: J) -> Done[R] | Loss:
    """Do a job in a worker process of this Ray process."""
    key = (order.token, group)
    if not any(token == order.token for token, _ in _workers):
        _settle(order.place)
    worker: Worker[J, R] | None = _workers.pop(key, None)
    while worker is None and len(_workers) >= _KEPT:
        _workers.pop(next(iter(_workers))).leave()
    for _ in range(STARTS):
        worker = worker or Worker(order.do, order.seconds, group, order.place.maths)
        outcome = worker.result(job)
        if not isinstance(outcome, Loss):
            _workers[key] = worker
            return outcome
        if outcome.doing:
            return outcome
        worker = None
    return outcome


def _settle(place: _Place) -> None:
    """Go where the run was started, if that is to be seen from here."""
    differences = [
        f"{name}: {there!r} where the run was started, {here!r} on node {platform.node()}"
        for name, there, here in [
            ("code", place.code, code_fingerprint()),
            *((name, place.packages[name], now) for name, now in package_versions().items()),
        ]
        if there != here
    ]
    if differences:
        raise IncompatibleResultsError(
            f"{'; '.join(differences)}: install the same version on every node"
        )
    if Path(place.folder).is_dir():
        os.chdir(place.folder)
    sys.path.extend(entry for entry in place.path if entry not in sys.path)


def _outcome(ray: Any, reference: Any) -> Done[Any] | Loss:  # noqa: ANN401  Ray's own
    try:
        outcome: Done[Any] | Loss = ray.get(reference)
        return outcome
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None
    except ray.exceptions.RayError as error:
        lines = str(error).strip().splitlines() or [type(error).__name__]
        return Loss("on the cluster", 0, f"{type(error).__name__}: {lines[0]}", 0.0)


def _knock(address: str | None) -> None:
    """Ray itself waits for minutes where nobody answers."""
    host, _, port = (address or "").rpartition(":")
    if not port.isdecimal():
        return
    try:
        socket.create_connection((host, int(port)), timeout=_ANSWER_SECONDS).close()
    except (OSError, OverflowError) as error:
        raise InvalidOptionError(f"no Ray cluster at address={address!r}: {error}") from error


@contextmanager
def _connected(address: str | None) -> Iterator[Any]:
    """Ray's own module while there is a connection; one that was there before stays."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    import ray

    if ray.is_initialized():
        yield ray
        return
    _knock(address)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        ray.init(address=address, logging_level="warning")
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise InvalidOptionError(f"no Ray cluster at address={address!r}: {error}") from error
    if threading.current_thread() is threading.main_thread():
        for number, handler in handlers.items():
            signal.signal(number, handler)  # Ray brings its own
    try:
        yield ray
    finally:
        ray.shutdown()
