"""Act one episode out and keep what the shards keep of it."""

from __future__ import annotations

import numpy as np

from icd_envs.demonstrations.shard import Recording
from icd_envs.tasks.base import SceneT, Task, run_expert
from icd_envs.tasks.problem import Split, scene_rng


def record(task: Task[SceneT], *, seed: int, steps: int, split: Split, noisy: bool) -> Recording:
    """Let the scripted expert act in a raw scene, solvable or not, without making a goal.

    Args:
        task: which one, with its options.
        seed: fixes the scene and every draw of the expert.
        steps: control steps at most; the episode ends earlier once success has held.
        split: which scenes.
        noisy: with action noise, varying speed and deliberate faults.
    """
    rng = scene_rng(split, seed)
    scene = task.draw_scenes(rng).scene
    plant = task.make_plant(scene)
    expert = task.make_expert(scene, rng, noisy=noisy)
    shown = run_expert(task, scene, plant, expert, steps)
    # A state that the physics blew up in is of no use to anyone.
    kept = len(shown.actions) - int(shown.diverged and len(shown.actions) > 0)
    return Recording(
        seed=seed,
        scene_id=plant.scene_id,
        parameters=task.parameters(scene),
        nodes=shown.nodes[: kept + 1].astype(np.float32),
        gripper=shown.gripper[: kept + 1],
        solved=shown.solved[: kept + 1],
        actions=shown.actions[:kept],
        success=shown.success,
        diverged=shown.diverged,
    )
