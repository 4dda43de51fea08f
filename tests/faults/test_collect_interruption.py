"""Collecting that is killed or interrupted loses and repeats nothing."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from icd_envs.demonstrations import Demonstrations
from icd_envs.demonstrations.header import Header
from tests.demonstrations.making import contents, make_header

ROOT = Path(__file__).parents[2]
SCRIPT = """
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from benchmarks.collect import collect
from benchmarks.executors import Local
from icd_envs.demonstrations.header import Header

@contextmanager
def slowly(total, rows):
    yield lambda row: time.sleep(0.05)

if __name__ == "__main__":
    out, workers, episodes = sys.argv[1:]
    header = Header(**{{**{fields!r}, "episodes": int(episodes)}})
    collect(header, Path(out), Local(int(workers)), watch=slowly)
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Collects in shards of one episode."""
    path = tmp_path_factory.mktemp("script") / "collect_some.py"
    header: Header = make_header(shard_episodes=1)
    path.write_text(SCRIPT.format(fields=vars(header)))
    return path


def start(script: Path, out: Path, workers: int, episodes: int) -> subprocess.Popen[str]:
    command = [sys.executable, str(script), str(out), str(workers), str(episodes)]
    return subprocess.Popen(
        command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def shards(out: Path) -> int:
    return len(list(out.glob("shard-*.npz")))


def finish(script: Path, out: Path, workers: int, episodes: int) -> dict[str, bytes]:
    process = start(script, out, workers, episodes)
    _, errors = process.communicate(timeout=240)
    assert process.returncode == 0, errors
    return contents(out)


@pytest.mark.parametrize(
    ("workers", "kills"),
    [(1, 3), (2, 2), pytest.param(1, 20, marks=pytest.mark.slow),
     pytest.param(2, 20, marks=pytest.mark.slow)],
)  # fmt: skip
def test_killed_and_resumed_folder_is_the_uninterrupted_one(
    script: Path, tmp_path: Path, workers: int, kills: int
) -> None:
    episodes = 3 * kills + 6
    whole = finish(script, tmp_path / "whole", workers, episodes)
    assert len(whole) == episodes + 1
    out, counts = tmp_path / "killed", [0]
    for delay in np.random.default_rng(kills + workers).uniform(0.0, 0.1, kills):
        process = start(script, out, workers, episodes)
        while shards(out) == counts[-1] and process.poll() is None:
            time.sleep(0.005)
        time.sleep(delay)  # somewhere in the next episodes
        process.kill()
        process.communicate()
        counts.append(shards(out))
        assert len(Demonstrations(out, partial=True)) == counts[-1]  # what is there is whole
    assert counts == sorted(counts)
    assert any(0 < count < episodes for count in counts), counts
    assert finish(script, out, 1, episodes) == whole
    assert not list(out.glob("*.tmp"))


@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_keeps_what_is_finished_and_exits_130(tmp_path: Path, workers: int) -> None:
    command = [sys.executable, "-m", "benchmarks", "collect", "--env", "ICDCableRouting-v0"]
    more = ["--episodes", "400", "--steps", "2", "--out", str(tmp_path), "--workers", str(workers)]
    process = subprocess.Popen(
        [*command, *more], cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    deadline = time.monotonic() + 60.0
    while not list(tmp_path.glob("shard-*.npz")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=30)
    assert process.returncode == 130, errors
    assert time.monotonic() - begun < 5.0
    assert (out, "Traceback" in errors) == ("", False)
    assert "the same command goes on" in errors
    assert len(Demonstrations(tmp_path, partial=True)) % 20 == 0
