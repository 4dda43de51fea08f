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
from pathlib import Path
from benchmarks.collect import collect
from benchmarks.executors import Local
from icd_envs.demonstrations.header import Header
if __name__ == "__main__":
    fields = {fields!r}
    collect(Header(**fields), Path(sys.argv[1]), Local(int(sys.argv[2])))
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Collects eight episodes in shards of one."""
    path = tmp_path_factory.mktemp("script") / "collect_some.py"
    header: Header = make_header(episodes=8, shard_episodes=1)
    path.write_text(SCRIPT.format(fields=vars(header)))
    return path


def start(script: Path, out: Path, workers: int) -> subprocess.Popen[str]:
    command = [sys.executable, str(script), str(out), str(workers)]
    return subprocess.Popen(
        command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def finish(script: Path, out: Path, workers: int = 1) -> dict[str, bytes]:
    process = start(script, out, workers)
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
    begun = time.monotonic()
    whole = finish(script, tmp_path / "whole", workers)
    duration = time.monotonic() - begun
    out = tmp_path / "killed"
    for moment in np.random.default_rng(kills + workers).uniform(0.3, 1.0, kills) * duration:
        process = start(script, out, workers)
        time.sleep(moment)
        process.kill()
        process.communicate()
        if (out / "demonstrations.json").exists() and list(out.glob("shard-*.npz")):
            Demonstrations(out, partial=True)  # what is there is whole
    assert finish(script, out) == whole
    assert len(whole) == 9
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
