"""States of the noisy expert in test scenes, described as the training data are."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, NamedTuple

import numpy as np

from benchmarks.collect import collect
from benchmarks.described import describe
from benchmarks.executors import InProcess
from icd_agent.episodes import sound_episodes
from icd_agent.states import EVERY, States
from icd_envs.api import Float32Array
from icd_envs.demonstrations import Demonstrations, find_task
from icd_envs.demonstrations.header import Header
from icd_envs.tasks.base import run_expert
from icd_envs.tasks.problem import Split, scene_rng

SPLIT: Final[Split] = "test"


class HeldOut(NamedTuple):
    """Episodes in test scenes, but those whose physics diverged.

    Attributes:
        states: every fifth, described, in memory.
        seeds: (E,) of the scenes.
        scenes: (E, M, 3) [m] their clouds.
    """

    states: States
    seeds: list[int]
    scenes: list[Float32Array]


def held_out(env_id: str, scenes: int, *, seed: int, field: Path | None) -> HeldOut:
    """Record the noisy expert in test scenes, and describe its states.

    Args:
        env_id: which task.
        scenes: how many episodes, one scene each.
        seed: of the scenes.
        field: folder of the field; None is the package's.

    Raises:
        IcdError: unknown environment, missing or damaged weights.
    """
    steps = find_task(env_id).max_steps
    header = Header(env_id=env_id, split=SPLIT, seed=seed, steps=steps, episodes=scenes)
    with TemporaryDirectory() as folder:
        data = Path(folder) / "test"
        collect(header, data, InProcess())
        states = describe(env_id, data, field, scenes, SPLIT).states
        recorded = Demonstrations(data)
        sound = sound_episodes(recorded, scenes)
        return HeldOut(
            states._replace(features=np.array(states.features), clouds=np.array(states.clouds)),
            [int(each) for each in recorded.seeds[sound]],
            [recorded.scene(int(i)).cloud for i in sound],
        )


def other_runs(env_id: str, seed: int, runs: int) -> Float32Array:
    """What else can happen in a test scene: (S, N, 3) [m] every fifth state of noisy experts.

    Args:
        env_id: which task.
        seed: of the scene.
        runs: how many episodes, with other experts than the recorded one.
    """
    task = find_task(env_id)
    scene = task.draw_scenes(scene_rng(SPLIT, seed)).scene
    clouds = []
    for run in range(runs):
        expert = task.make_expert(scene, np.random.default_rng([seed, run]), noisy=True)
        clouds.append(run_expert(task, scene, task.make_plant(scene), expert).points[::EVERY])
    return np.concatenate(clouds)
