"""Episodes of the scripted experts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from types import MappingProxyType
from typing import Final

import gymnasium as gym

from icd_envs.errors import InvalidOptionError, unknown_name
from icd_envs.registration import check_env_id
from icd_envs.tasks.base import Demonstration, SceneT, Task, run_expert
from icd_envs.tasks.cable_routing import CableRouting, CableRoutingAdaptation
from icd_envs.tasks.env import ContactEnv
from icd_envs.tasks.notebook_folding import NotebookFolding, NotebookFoldingAdaptation
from icd_envs.tasks.problem import Split, scene_rng

TASKS: dict[str, Task] = {  # type: ignore[type-arg]
    task.env_id: task
    for task in (
        CableRouting(),
        NotebookFolding(),
        CableRoutingAdaptation(),
        NotebookFoldingAdaptation(),
    )
}


NO_OPTIONS: Final[Mapping[str, object]] = MappingProxyType({})


def find_task(env_id: str, options: Mapping[str, object] = NO_OPTIONS) -> Task:  # type: ignore[type-arg]
    """The task behind an environment.

    Args:
        env_id: of the environment: one of ``TASKS``, or of your own as ``gymnasium.make`` takes it,
            with the module to import, ``my_task:MyTask-v0``, or without once that is imported.
        options: arguments of ``gymnasium.make`` that change scenes and goals, by name.

    Raises:
        InvalidOptionError: on an unknown id or option, a value that an option cannot take, or an
            environment that has no task.
    """
    task = TASKS[env_id] if env_id in TASKS else _registered_task(env_id)
    known = tuple(field.name for field in fields(task)) if is_dataclass(task) else ()
    for name in options:
        if name not in known:
            raise InvalidOptionError(unknown_name(f"option of the task {env_id}:", name, known))
    return replace(task, **options) if options else task  # type: ignore[type-var]


def _registered_task(env_id: str) -> Task:  # type: ignore[type-arg]
    check_env_id(env_id)
    env = gym.make(env_id)
    env.close()
    if not isinstance(env.unwrapped, ContactEnv):
        raise InvalidOptionError(
            f"environment {env_id!r} is a {type(env.unwrapped).__name__}, which has no task and no "
            "expert: build it on icd_envs.tasks.env.ContactEnv, see docs/own-task.md"
        )
    return env.unwrapped.task


def demonstrate(
    env_id: str, *, seed: int, split: Split = "train", noisy: bool = False
) -> Demonstration:
    """Let the scripted expert act once in a raw scene, solvable or not.

    Args:
        env_id: which environment.
        seed: fixes the scene and every draw of the expert.
        split: which scenes.
        noisy: with action noise, varying speed and deliberate faults.
    """
    return demonstrate_task(find_task(env_id), seed=seed, split=split, noisy=noisy)


def demonstrate_task(
    task: Task[SceneT], *, seed: int, split: Split = "train", noisy: bool = False
) -> Demonstration:
    """The same for a task with options, e.g. ``CableRouting(num_fixtures=3)``."""
    rng = scene_rng(split, seed)
    scene = task.draw_scenes(rng).scene
    plant = task.make_plant(scene)
    return run_expert(task, scene, plant, task.make_expert(scene, rng, noisy=noisy))
