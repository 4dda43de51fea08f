"""Training that is killed with SIGKILL goes on to the weights of a run that was not."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.faults.training_run import RUNS, TRAINING

ROOT = Path(__file__).parents[2]


def start(kind: str, out: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "tests.faults.training_run", kind, str(out)]
    return subprocess.Popen(command, cwd=ROOT, text=True, stderr=subprocess.PIPE)


def finish(kind: str, out: Path) -> bytes:
    process = start(kind, out)
    _, errors = process.communicate(timeout=240)
    assert process.returncode == 0, errors
    return (out / "model.safetensors").read_bytes()


def lines(out: Path) -> int:
    log = out / "training.jsonl"
    return len(log.read_text().splitlines()) if log.exists() else 0


@pytest.mark.parametrize("kind", RUNS)
def test_killed_training_ends_with_the_same_weights(kind: str, tmp_path: Path) -> None:
    whole, killed = finish(kind, tmp_path / "whole"), tmp_path / "killed"
    for after in (1, 10):  # before the first save, and after it
        before, process = lines(killed), start(kind, killed)
        while process.poll() is None and lines(killed) < before + after:
            time.sleep(0.005)
        process.kill()
        process.communicate()
        assert process.returncode == -signal.SIGKILL
        assert not (killed / "model.safetensors").exists()
    assert lines(killed) > TRAINING.save_every
    assert finish(kind, killed) == whole
