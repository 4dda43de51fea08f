"""The task in docs/own-task.md is one: made, benchmarked, recorded, read, and trained on."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from benchmarks import diagnose_diffusion
from benchmarks.registry import Offer, make_agent
from tests.bench.making import icd_bench
from tests.envs.glb import reloaded

PAGE = (Path(__file__).parents[2] / "docs" / "own-task.md").read_text("utf-8")
COMMANDS = re.findall(r"^icd-bench (.*)$", PAGE.replace("\\\n", ""), re.M)
ENV = "my_task:StrictFolding-v0"
LITTLE = {
    "collect": "--episodes 2 --steps 10 --workers 1",
    "field": "--steps 2 --scenes 2 --anchors 16",
    "latent": "--steps 2",
    "diffusion": "--steps 2",
    "subgoal-diffuser": "--steps 2 --latent-steps 2",
    "global-ndf": "--steps 2 --latent-steps 2 --field-steps 2",
    "diffusion-policy": "--steps 2 --all-episodes",
    "dp3": "--steps 2 --all-episodes",
    "diagnose": "--scenes 2",
}
"""What makes the page's commands quick."""

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
    benchmark, record = COMMANDS[:2]
    smaller = benchmark.replace("--agent pc-mppi ", "").replace("--episodes 20", "--episodes 1")
    assert smaller.count("--agent") == 1
    (row,) = json.loads(run(folder, "-m", "benchmarks", *smaller.split(), "--json"))
    assert (row["agent"], row["episodes"], row["errors"], row["success"]) == ("expert", 1, 0, 1)
    few = record.replace("--episodes 1500", "--episodes 1 --steps 5")
    run(folder, "-m", "benchmarks", *few.split())
    said = run(folder, "-c", USE).splitlines()
    assert said[0] == "import it first False"
    assert said[1] == "StrictFolding-v0 200 True False"
    assert said[2] == "1 (6, 200, 3)"
    run(folder, "-m", "benchmarks", "export-scene", "--env", ENV, "--out", "scene.glb")
    assert {"sheet_0", "sheet_7", "finger_right"} <= set(reloaded(folder / "scene.glb"))


@pytest.fixture
def imported(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Beside the module, which is forgotten in the end."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr("sys.path", [*sys.path])
    monkeypatch.setattr(diagnose_diffusion, "RUNS", 1)
    yield folder
    sys.modules.pop("my_task", None)
    gym.registry.pop("StrictFolding-v0", None)


def test_every_network_is_trained_for_the_task_of_the_page_and_acts_in_it(imported: Path) -> None:
    agents = []
    for command in COMMANDS[1:]:
        verb, kind, *_ = command.split()
        if verb == "run":
            agents += re.findall(r"--agent (\S+)", command)
            continue
        little = LITTLE[verb] if verb in LITTLE else LITTLE[kind]
        done = icd_bench(*command.split(), *little.split())
        assert done.exit_code == 0, (command, done.stderr)
    assert [name.partition("@")[0] for name in agents] == [
        "icd", "subgoal-diffuser", "diffusion-policy", "dp3", "global-ndf",
    ]  # fmt: skip
    env = gym.make(ENV)
    observation, _ = env.reset(seed=0)
    unwrapped: Any = env.unwrapped
    for name in agents[:3]:
        agent = make_agent(name, Offer(ENV))
        agent.reset(unwrapped.episode(simulator=agent.needs_simulator), seed=0)
        assert np.abs(agent.act(observation)).max() <= 1
    env.close()
    refused = icd_bench(*["train", "latent", "--out", "x", "--data", "data/strict", "--env"], ENV)
    assert refused.exit_code == 2
    assert "environment with shipped weights" in refused.stderr
