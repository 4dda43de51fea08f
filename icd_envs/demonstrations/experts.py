"""Episodes of the scripted experts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from types import MappingProxyType
from typing import Final

from icd_envs.errors import InvalidOptionError, unknown_name
from icd_envs.tasks.base import Demonstration, SceneT, Task, run_expert
from icd_envs.tasks.cable_routing import CableRouting, CableRoutingAdaptation
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
        env_id: of the environment.
        options: arguments of ``gymnasium.make`` that change scenes and goals, by name.

    Raises:
        InvalidOptionError: on an unknown id or option, or a value that an option cannot take.
    """
    if env_id not in TASKS:
        raise InvalidOptionError(unknown_name("environment id", env_id, TASKS))
    task = TASKS[env_id]
    known = tuple(field.name for field in fields(task))  # type: ignore[arg-type]
    for name in options:
        if name not in known:
            raise InvalidOptionError(unknown_name(f"option of the task {env_id}:", name, known))
    return replace(task, **options)  # type: ignore[type-var]


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
