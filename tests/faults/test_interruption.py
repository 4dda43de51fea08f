"""Runs that are killed or interrupted lose and repeat nothing."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from filelock import FileLock

from benchmarks.results import ROWS_NAME, read_rows
from tests.bench import toy
from tests.bench.making import in_order

ROOT = Path(__file__).parents[2]
EPISODES = 6


def command(out: Path, *more: str) -> list[str]:
    run = ["run", "--agent", toy.spec(toy.Raiser), "--agent", toy.spec(toy.Slow), "--env", toy.ENV]
    plan = ["--episodes", str(EPISODES), "--seed", "7", "--out", str(out), "--json", *more]
    return [sys.executable, "-m", "benchmarks", *run, *plan]


def start(out: Path, *more: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        command(out, *more), cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def finish(out: Path, *more: str) -> str:
    done = subprocess.run(command(out, *more), cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr  # Raiser's errors
    return done.stdout


def wait_for_rows(out: Path, count: int, process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 60.0
    while count_rows(out) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)


def count_rows(out: Path) -> int:
    return (out / ROWS_NAME).read_bytes().count(b"\n") if (out / ROWS_NAME).exists() else 0


def wait_until_dead(locks: Path, seconds: float) -> int:
    """Number of processes whose agent held a lock; the system releases it when they die."""
    for path in locks.iterdir():
        with FileLock(path, timeout=seconds):
            pass
    return len(list(locks.iterdir()))


@pytest.mark.parametrize(
    ("episodes", "kills"), [(4, 3), pytest.param(40, 20, marks=pytest.mark.slow)]
)
def test_run_killed_at_random_moments_resumes_to_the_uninterrupted_table(
    tmp_path: Path, episodes: int, kills: int
) -> None:
    many = ("--episodes", str(episodes))
    table = finish(tmp_path / "whole", *many)
    killed = tmp_path / "killed"
    rng = np.random.default_rng(kills)
    progress = [0]
    for _ in range(kills):
        process = start(killed, *many, "--resume", "--workers", str(rng.integers(1, 3)))
        wait_for_rows(killed, progress[-1] + int(rng.integers(0, 4)), process)
        time.sleep(rng.uniform(0.0, 0.3))
        process.kill()
        assert process.wait() == -signal.SIGKILL
        process.communicate()
        progress.append(count_rows(killed))
    assert len(set(progress)) > kills // 2
    assert json.loads(finish(killed, *many, "--resume")) == json.loads(table)
    assert in_order(read_rows(killed)) == in_order(read_rows(tmp_path / "whole"))
    assert count_rows(killed) == 2 * episodes


@pytest.mark.parametrize(
    ("number", "workers"), [(signal.SIGINT, 1), (signal.SIGINT, 2), (signal.SIGTERM, 2)]
)
def test_interrupt_prints_the_partial_table_and_exits_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, workers: int
) -> None:
    monkeypatch.setenv(toy.LOCKS, str(tmp_path / "locks"))
    sleeper = ("--agent", toy.spec(toy.Sleeper))
    process = start(tmp_path / "out", *sleeper, "--workers", str(workers))
    wait_for_rows(tmp_path / "out", EPISODES + 1, process)  # of Raiser, then one of Slow
    begun = time.monotonic()
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 128 + number, err
    assert time.monotonic() - begun < 5.0
    episodes = sum(record["episodes"] for record in json.loads(out))
    assert episodes == len(read_rows(tmp_path / "out")) > EPISODES
    assert "--resume" in err
    assert "Traceback" not in err
    assert wait_until_dead(tmp_path / "locks", seconds=5.0) >= 1


def test_workers_do_not_outlive_a_killed_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(toy.LOCKS, str(tmp_path / "locks"))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    process = start(tmp_path / "out", "--workers", "2")
    wait_for_rows(tmp_path / "out", EPISODES + 1, process)  # of Raiser, then one of Slow
    process.kill()
    process.wait()
    assert wait_until_dead(tmp_path / "locks", seconds=5.0) >= 1
    assert not list(tmp_path.glob("icd-bench-*"))
