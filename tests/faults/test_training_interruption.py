"""Training that is killed with SIGKILL goes on to the weights of a run that was not."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from icd_agent.training.loop import LOG_NAME, STATE_NAME
from tests.faults.training_run import RUNS, TRAINING

ROOT = Path(__file__).parents[2]


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tests.faults.training_run", *map(str, arguments)]
    return subprocess.run(
        command, cwd=ROOT, text=True, capture_output=True, check=False, timeout=240
    )


def finish(kind: str, out: Path) -> bytes:
    finished = run(kind, out)
    assert finished.returncode == 0, finished.stderr
    return (out / "model.safetensors").read_bytes()


def logged(out: Path) -> list[int]:
    return [json.loads(line)["step"] for line in (out / LOG_NAME).read_text().splitlines()]


KINDS = [
    kind if kind == "diffusion" else pytest.param(kind, marks=pytest.mark.slow) for kind in RUNS
]
"""One in the fast suite: all three share the loop that saves and goes on."""


@pytest.mark.parametrize("kind", KINDS)
def test_killed_training_ends_with_the_same_weights(kind: str, tmp_path: Path) -> None:
    whole, killed = finish(kind, tmp_path / "whole"), tmp_path / "killed"
    assert (TRAINING.steps, TRAINING.save_every, TRAINING.log_every) == (60, 7, 1)
    assert run(kind, killed, 3).returncode == -signal.SIGKILL
    assert not (killed / STATE_NAME).exists()
    assert run(kind, killed, 30).returncode == -signal.SIGKILL
    assert torch.load(killed / STATE_NAME, weights_only=True)["step"] == 28
    assert not (killed / "model.safetensors").exists()
    assert finish(kind, killed) == whole
    assert logged(killed) == list(range(1, TRAINING.steps + 1))
