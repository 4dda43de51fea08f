"""Episodes of the scripted experts."""

from __future__ import annotations

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


def find_task(env_id: str) -> Task:  # type: ignore[type-arg]
    """The task behind an environment.

    Raises:
        InvalidOptionError: if there is none of that id.
    """
    if env_id not in TASKS:
        raise InvalidOptionError(unknown_name("environment id", env_id, TASKS))
    return TASKS[env_id]


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
