"""The command line on the real environment."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

CLI = [sys.executable, "-m", "benchmarks"]
ENV_ID = "ICDCableRouting-v0"


def table(*arguments: str) -> list[dict[str, object]]:
    result = subprocess.run(
        [*CLI, *arguments, "--json"], capture_output=True, text=True, check=False, timeout=3000
    )
    assert result.returncode == 0, result.stderr
    rows: list[dict[str, object]] = json.loads(result.stdout)
    return rows


def test_expert_solves_and_random_does_not(tmp_path: Path) -> None:
    expert, random = table(
        "run", "--agent", "expert", "--agent", "random", "--env", ENV_ID, "--episodes", "3",
        "--workers", "2", "--out", str(tmp_path / "out"),
    )  # fmt: skip
    assert (expert["agent"], expert["success"], expert["errors"]) == ("expert", 1.0, 0)
    assert (random["agent"], random["success"], random["errors"]) == ("random", 0.0, 0)


@pytest.mark.slow
@pytest.mark.timeout(3000)
def test_pc_mppi_killed_and_resumed_gives_the_uninterrupted_table(tmp_path: Path) -> None:
    def arguments(out: str) -> list[str]:
        words = f"run --agent pc-mppi --env {ENV_ID} --episodes 3 --seed 7 --out {tmp_path / out}"
        return words.split()

    killed = subprocess.Popen([*CLI, *arguments("a")], stderr=subprocess.DEVNULL)
    rows = tmp_path / "a" / "episodes.jsonl"
    deadline = time.monotonic() + 1500
    while not (rows.exists() and rows.read_text(encoding="utf-8").count("\n") >= 1):
        assert killed.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.5)
    os.kill(killed.pid, signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    assert table(*arguments("a"), "--resume") == table(*arguments("b"))
