"""What an episode starts from: a scene that can be solved, and a goal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Generic, Literal

import numpy as np

from icd_envs.api import BoolArray, Float32Array, Float64Array, Oracle
from icd_envs.errors import SceneGenerationError
from icd_envs.physics.plant import Plant
from icd_envs.tasks.base import SceneT, Task, run_expert

Split = Literal["train", "test"]
SPLITS: Final[tuple[Split, ...]] = ("train", "test")

MAX_ATTEMPTS: Final = 20
"""Scenes drawn for one seed before giving up on finding one that the expert solves."""


@dataclass(frozen=True)
class Problem(Generic[SceneT]):
    """A scene with its start state, a goal, and a way to solve it.

    Attributes:
        scene: what was drawn.
        plant: compiled scene, in its start state.
        oracle: how the expert solved it.
        goal_scene: where the goal was specified.
        goal_oracle: how the expert solved that one; the goal is its last cloud.
        parameters: of the task in the present scene, and with the prefix ``goal_`` in the goal's.
    """

    scene: SceneT
    plant: Plant
    oracle: Oracle
    goal_scene: SceneT
    goal_oracle: Oracle
    parameters: dict[str, Float64Array]

    @property
    def goal(self) -> Float32Array:
        """(N, 3) [m] object cloud to reach."""
        return self.goal_oracle.points[-1]


def matched_parts(task: Task[SceneT], problem: Problem[SceneT], points: Float32Array) -> BoolArray:
    """(F,) parts of the problem's goal that an object cloud (N, 3) [m] reaches."""
    parameters = {name: value[None] for name, value in problem.parameters.items()}
    return task.matches(points[None], problem.goal[None], parameters)[0]


def draw_problem(task: Task[SceneT], rng: np.random.Generator, seed: int) -> Problem[SceneT]:
    """Draw scenes until the clean expert solves them.

    Raises:
        SceneGenerationError: if none of ``MAX_ATTEMPTS`` scenes was solved.
    """
    for _ in range(MAX_ATTEMPTS):
        scene, goal_scene = task.draw_scenes(rng)
        plant = task.make_plant(scene)
        oracle = _solve(task, scene, plant)
        if oracle is None:
            continue
        goal_oracle: Oracle | None = oracle
        if goal_scene is not scene:
            goal_oracle = _solve(task, goal_scene, task.make_plant(goal_scene))
        if goal_oracle is not None:
            goal_parameters = task.parameters(goal_scene)
            parameters = {
                **task.parameters(scene),
                **{f"goal_{name}": value for name, value in goal_parameters.items()},
            }
            return Problem(scene, plant, oracle, goal_scene, goal_oracle, parameters)
    raise SceneGenerationError(
        f"{task.env_id}: the expert solved none of {MAX_ATTEMPTS} scenes drawn with seed {seed}: "
        "use another seed"
    )


def _solve(task: Task[SceneT], scene: SceneT, plant: Plant) -> Oracle | None:
    """The clean expert's solution, None if it failed; the plant is left in its start state."""
    start = plant.get_state()
    demonstration = run_expert(task, scene, plant, task.make_expert(scene))
    plant.set_state(start)
    if not demonstration.success:
        return None
    return Oracle(scene, demonstration.points, demonstration.actions)


def scene_rng(split: Split, seed: int) -> np.random.Generator:
    """Generator of everything random in an episode; splits never share a stream."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(SPLITS.index(split),)))


def sensor_rng(split: Split, seed: int, step: int) -> np.random.Generator:
    """Generator of a sensor's noise at one step: it depends on nothing else that happened."""
    key = (SPLITS.index(split), step)  # longer than a scene's key: never the same stream
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
