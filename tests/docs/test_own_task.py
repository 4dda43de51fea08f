"""The task in docs/own-task.md is one: it is made, benchmarked, recorded and read."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "own-task.md").read_text("utf-8")

USE = """
import sys
import gymnasium as gym
import numpy as np
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.notebook_folding import NotebookFolding

try:
    Demonstrations("data/strict")
except InvalidOptionError:
    print("import it first", "my_task" in sys.modules)
env = gym.make("my_task:StrictFolding-v0", split="test", max_episode_steps=200)
env.reset(seed=0)
episode, near = env.unwrapped.episode(oracle=True), False
for action in episode.oracle.actions:
    observation, _, _, _, info = env.step(np.zeros(3) if near else action)
    clouds = observation["achieved_goal"][None], observation["desired_goal"][None]
    near = near or bool(NotebookFolding().matches(*clouds, info).all())
print(episode.env_id, episode.max_steps, near, info["is_success"])
print(len(Demonstrations("data/strict")), Demonstrations("data/strict").replay(0).shape)
"""


def run(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True, text=True, check=False, timeout=240, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    (tmp_path / "my_task.py").write_text(code, encoding="utf-8")
    return tmp_path


def test_task_of_the_page_is_benchmarked_recorded_and_read(folder: Path) -> None:
    benchmark, record = re.findall(r"^icd-bench (.*)$", PAGE, re.M)
    smaller = benchmark.replace("--agent pc-mppi ", "").replace("--episodes 20", "--episodes 1")
    assert smaller.count("--agent") == 1
    (row,) = json.loads(run(folder, "-m", "benchmarks", *smaller.split(), "--json"))
    assert (row["agent"], row["episodes"], row["errors"], row["success"]) == ("expert", 1, 0, 1)
    few = record.replace("--episodes 100", "--episodes 1 --steps 5")
    run(folder, "-m", "benchmarks", *few.split())
    said = run(folder, "-c", USE).splitlines()
    assert said[0] == "import it first False"
    assert said[1] == "StrictFolding-v0 200 True False"
    assert said[2] == "1 (6, 200, 3)"
