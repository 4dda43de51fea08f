"""Small folders of demonstrations."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.collect import collect
from benchmarks.executors import InProcess
from icd_envs.demonstrations.header import Header
from icd_envs.demonstrations.shard import Recording
from tests.envs.making import CABLE

STEPS = 6


def make_header(**fields: object) -> Header:
    """A header of a few short episodes in shards of two, but for the fields given."""
    defaults: dict[str, object] = {
        "env_id": CABLE,
        "seed": 5,
        "steps": STEPS,
        "episodes": 3,
        "shard_episodes": 2,
    }
    return Header(**{**defaults, **fields})


def make_folder(out: Path, **fields: object) -> Path:
    """A folder of short episodes."""
    collect(make_header(**fields), out, InProcess())
    return out


def make_recording(steps: int = 2, seed: int = 0, **fields: object) -> Recording:
    """An episode of numbers without meaning."""
    rng = np.random.default_rng(seed)
    defaults: dict[str, object] = {
        "seed": seed,
        "scene_id": "0123456789abcdef",
        "parameters": {"clips": rng.normal(size=(2, 3))},
        "nodes": rng.normal(size=(steps + 1, 4, 3)).astype(np.float32),
        "gripper": rng.normal(size=(steps + 1, 6)).astype(np.float32),
        "solved": rng.random((steps + 1, 2)) < 0.5,
        "actions": rng.uniform(-1, 1, (steps, 3)).astype(np.float32),
        "success": False,
        "diverged": False,
    }
    return Recording(**{**defaults, **fields})


def contents(folder: Path) -> dict[str, bytes]:
    """Every file that must not depend on how a folder was filled."""
    files = [*folder.glob("shard-*"), folder / "demonstrations.json"]
    return {path.name: path.read_bytes() for path in files}
