"""Folders that cannot be written, environments that lack something, orders that differ."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest

from benchmarks.executors import Executor, Local, Work
from benchmarks.results import ROWS_NAME, read_rows
from benchmarks.rows import Row
from tests.bench import toy
from tests.bench.making import in_order, run_toys

J = TypeVar("J")
R = TypeVar("R")
ROOT = Path(__file__).parents[2]
EPISODES = 200


class Shuffled:
    """Does the jobs in another order."""

    threads = 1

    def __init__(self, executor: Executor, seed: int) -> None:
        self._executor, self._rng = executor, np.random.default_rng(seed)

    def execute(self, work: Work[J, R], jobs: Sequence[J]) -> Generator[R, None, None]:
        return self._executor.execute(work, [jobs[i] for i in self._rng.permutation(len(jobs))])


def lines(rows: list[Row]) -> list[bytes]:
    return [row.to_line().encode() for row in rows]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """Rows of one worker, but for times."""
    out = tmp_path_factory.mktemp("one")
    return lines(run_toys(out, toy.Drunk, toy.Gambler, toy.Raiser, executor=Local(1)))


@pytest.mark.parametrize("executor", [Local(2), Local(4), Shuffled(Local(1), 0)])
def test_rows_are_the_same_bytes_for_any_workers_and_order(
    executor: Executor, expected: list[bytes], tmp_path: Path
) -> None:
    rows = run_toys(tmp_path, toy.Drunk, toy.Gambler, toy.Raiser, executor=executor)
    assert lines(rows) == expected
    assert lines(in_order(read_rows(tmp_path))) == expected


def command(out: Path | str, *more: str) -> list[str]:
    run = ["run", "--agent", toy.spec(toy.Drunk), "--env", toy.ENV, "--episodes", str(EPISODES)]
    return [sys.executable, "-m", "benchmarks", *run, "--out", str(out), *more]


def start(command: list[str], **options: object) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, text=True, **{"env": environment, **pipes, **options})


def wait_for(file: Path, process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 60.0
    while not (file.exists() and file.stat().st_size):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.002)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of another process")
def test_full_disk_ends_the_run_in_one_line_and_resumes(tmp_path: Path) -> None:
    process = start(command(tmp_path))
    wait_for(tmp_path / ROWS_NAME, process)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (8_000, 8_000))
    out, error = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    message = error.splitlines()[-1]
    assert ROWS_NAME in message
    assert "icd-bench: cannot write" in message
    assert (tmp_path / ROWS_NAME).read_bytes().count(b"\n") < EPISODES
    resumed = start(command(tmp_path, "--resume"))
    assert f"{EPISODES}/{EPISODES}" in resumed.communicate(timeout=120)[1]
    assert resumed.returncode == 0
    assert len(read_rows(tmp_path)) == EPISODES


@pytest.mark.parametrize("out", ["/proc/nowhere/out", "/dev/null/out"])
def test_folder_that_cannot_be_made_is_refused_before_the_first_episode(out: str) -> None:
    process = start(command(out))
    shown, error = process.communicate(timeout=60)
    assert (process.returncode, shown) == (2, "")
    assert "choose another --out" in error
    assert "episodes" not in error


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_folder_is_refused_before_the_first_episode(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    process = start(command(tmp_path / "out"))
    assert "choose another --out" in process.communicate(timeout=60)[1]
    assert process.returncode == 2


def test_run_needs_no_home_and_bears_any_path(tmp_path: Path) -> None:
    folder = tmp_path / "späce d 'quoted' 界"
    folder.mkdir()
    bare = {name: os.environ[name] for name in ("PATH", "OMP_NUM_THREADS") if name in os.environ}
    environment = {**bare, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)}
    short = [word if word != str(EPISODES) else "2" for word in command("out dir")]
    process = start(short, cwd=folder, env=environment)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 0, error
    assert len(read_rows(folder / "out dir")) == 2
    assert {path.name for path in folder.iterdir()} == {"out dir"}, "nothing is left behind"
    assert "2/2" in out or "1/2" in out or "0/2" in out


def test_second_run_in_the_same_folder_is_refused_and_the_first_goes_on(tmp_path: Path) -> None:
    first = start(command(tmp_path, "--agent", toy.spec(toy.Sleeper), "--workers", "2"))
    wait_for(tmp_path / ROWS_NAME, first)
    second = start(command(tmp_path, "--resume"))
    refused = second.communicate(timeout=60)[1]
    assert second.returncode == 2
    assert "in use by another run" in refused
    assert first.poll() is None
    first.terminate()
    first.communicate(timeout=60)
    assert first.returncode == 143
