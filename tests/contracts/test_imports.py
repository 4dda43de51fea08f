"""What importing our packages loads: heavy libraries only where they are needed."""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
HEAVY = {"torch", "mujoco", "dm_control", "trimesh", "stable_baselines3", "diffusers"}

SCRIPT = """
import importlib, json, os, random, sys
before = dict(os.environ), random.getstate(), sorted(os.listdir("."))
for name in sys.argv[1:]:
    importlib.import_module(name)
after = dict(os.environ), random.getstate(), sorted(os.listdir("."))
roots = sorted({name.partition(".")[0] for name in sys.modules})
print(json.dumps([roots, before == after]))
"""


def loaded(*modules: str) -> set[str]:
    """Top-level packages that are in memory once ``modules`` are imported in a new process."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *modules], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    roots, untouched = json.loads(done.stdout.splitlines()[-1])
    assert untouched, "importing changed the environment, the RNG or the working directory"
    assert done.stdout.count("\n") == 1
    return set(roots)


@pytest.mark.parametrize(
    ("module", "unwanted"),
    [
        ("icd_envs", HEAVY),
        ("icd_envs.api", HEAVY | {"scipy"}),
        ("icd_envs.errors", HEAVY),
        ("icd_envs.wrappers", HEAVY),
        ("icd_agent.mppi.presets", HEAVY),
        ("icd_agent.tracking", {"torch", "stable_baselines3", "diffusers"}),
        ("benchmarks.cli", HEAVY | {"gymnasium", "matplotlib"}),
        ("benchmarks.registry", HEAVY | {"matplotlib"}),
    ],
)
def test_import_loads_no_more_than_it_needs(module: str, unwanted: set[str]) -> None:
    assert loaded(module) & unwanted == set()


def cpu_seconds(*command: str) -> float:
    """User and system time of a finished process, which hardly depends on the machine's load."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *command], cwd=ROOT, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_start_up_takes_little_more_than_numpy_and_gymnasium_do() -> None:
    measure = ("-c", "import numpy, gymnasium")
    commands = {("-c", "import icd_envs"): 1.7, ("-m", "benchmarks", "--help"): 1.9}
    least = dict.fromkeys([measure, *commands], math.inf)
    # In turn, and more often on a busy machine, which slows now the one and now the other.
    for count in range(1, 11):
        for command in least:
            least[command] = min(least[command], cpu_seconds(*command))
        quick = all(least[name] < most * least[measure] for name, most in commands.items())
        if quick and count >= 3:
            break
    assert quick, least


def test_importing_twice_registers_once() -> None:
    import gymnasium as gym

    import icd_envs

    before = dict(gym.registry)
    icd_envs.register_envs()
    assert gym.registry == before
    assert set(icd_envs.ENV_IDS) <= set(gym.registry)
