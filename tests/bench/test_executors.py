"""Executors on jobs that are numbers."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time
from pathlib import Path

import pytest

from benchmarks.errors import WorkerStartError
from benchmarks.executors import Executor, InProcess, Local, Retry, Work, make_executor
from benchmarks.provenance import cpu_count
from benchmarks.pulse import Pulse
from benchmarks.worker import Loss
from icd_envs.errors import InvalidOptionError


def square(job: int, pulse: Pulse) -> int:
    return job * job


def who(job: int, pulse: Pulse) -> tuple[int, int]:
    return job, os.getpid()


def world(job: str, pulse: Pulse) -> str:
    """Something about the process."""
    if job == "litter":
        return tempfile.mkdtemp()
    return os.environ["OMP_NUM_THREADS"]


def misbehave(job: int, pulse: Pulse) -> int:
    """Odd numbers hang, die, or cannot be sent."""
    pulse.step = job
    if job == 1:
        os._exit(3)
    if job == 3:
        os.kill(os.getpid(), signal.SIGSEGV)
    if job == 5:
        with pulse.limited("thinking", 0.2):
            time.sleep(60.0)
    if job == 7:
        pulse.doing = "dreaming"
        time.sleep(60.0)
    return -job


def fail(job: int, pulse: Pulse) -> object:
    if job == 0:
        raise InvalidOptionError("no such thing")
    return lambda: job


def lost(job: int, loss: Loss) -> str:
    return f"{job}: {loss}"


def again(job: int, loss: Loss) -> Retry[int]:
    return Retry(job + 1)


@pytest.mark.parametrize("executor", [InProcess(), Local(1), Local(3)])
def test_every_job_is_done_once(executor: Executor) -> None:
    results = list(executor.execute(Work(square, lost), range(20)))
    assert sorted(results) == [job * job for job in range(20)]
    assert list(executor.execute(Work(square, lost), [])) == []


def test_job_that_kills_or_hangs_its_worker_is_lost_alone() -> None:
    work = Work(misbehave, lost, seconds=2.0)
    results = list(Local(2).execute(work, range(8)))
    assert sorted(map(str, results)) == [
        "-2", "-4", "-6", "0",
        "1: beginning, step 1: worker died (exit status 3)",
        "3: beginning, step 3: worker died (signal 11)",
        "5: thinking, step 5: over its time budget of 0.2 s",
        "7: dreaming, step 7: over its time budget of 2 s in all",
    ]  # fmt: skip


def test_lost_job_may_be_replaced_by_another_attempt() -> None:
    assert list(Local(1).execute(Work(misbehave, again), [1, 3])) == [-2, -4]


def test_groups_never_share_a_process_and_keep_theirs() -> None:
    def group(job: int) -> str:
        return str(job % 3)

    work = Work(who, lost, group)
    for workers, least in ((1, 3), (2, 4)):
        groups: dict[int, set[str]] = {}
        for job, pid in Local(workers).execute(work, range(12)):
            groups.setdefault(pid, set()).add(group(job))
        assert all(len(served) == 1 for served in groups.values())
        assert len(groups) <= least
        assert os.getpid() not in groups


@pytest.mark.parametrize(("job", "message"), [(0, "no such thing"), (1, "cannot be sent")])
def test_what_a_job_raises_ends_the_run(job: int, message: str) -> None:
    with pytest.raises((InvalidOptionError, RuntimeError), match=message):
        list(Local(2).execute(Work(fail, lost), [job]))


def test_workers_that_cannot_start_are_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(square, "__qualname__", "gone")
    monkeypatch.setattr(sys.modules[__name__], "gone", square, raising=False)
    with pytest.raises(WorkerStartError, match=r"exit status 1.*__main__"):
        list(Local(1).execute(Work(square, lost), [1]))


def test_worker_has_one_maths_thread_unless_the_user_says_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    assert list(Local(1).execute(Work(world, lost), ["threads"])) == ["1"]
    assert "OMP_NUM_THREADS" not in os.environ
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    assert list(Local(1).execute(Work(world, lost), ["threads"])) == ["2"]


def test_temporary_files_of_a_worker_go_with_it() -> None:
    (folder,) = Local(1).execute(Work(world, lost), ["litter"])
    assert not Path(folder).exists()


def test_closing_early_ends_the_workers_at_once() -> None:
    results = Local(2).execute(Work(misbehave, lost), [0, 7, 7])
    assert next(results) == 0
    begun = time.monotonic()
    results.close()
    assert time.monotonic() - begun < 2.0


def test_cores_are_shared_unless_threads_are_given() -> None:
    assert Local(1).threads == cpu_count()
    assert Local(10_000).threads == 1
    assert Local(2, threads_each=5).threads == 5


def test_executors_are_made_by_name() -> None:
    options = {"workers": 2, "threads": None, "address": None}
    assert make_executor("local", **options) == Local(2)
    assert make_executor("local", **{**options, "workers": 0}) == InProcess()
    with pytest.raises(InvalidOptionError, match="did you mean 'local'"):
        make_executor("locl", **options)
    with pytest.raises(InvalidOptionError, match="--executor ray"):
        make_executor("local", **{**options, "address": "auto"})
