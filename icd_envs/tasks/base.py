"""What a task is: the parts of an environment that differ from task to task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from icd_envs.api import BoolArray, Float32Array, Float64Array, FloatArray
from icd_envs.physics.plant import Plant
from icd_envs.scenes.boxes import Box

HOLD_STEPS: Final = 10
"""Control steps for which success must hold before an episode ends, where it ends early."""
IDLE_STEPS: Final = 20
"""Control steps that an expert is watched for after it is done."""

SceneT = TypeVar("SceneT")


class Scenes(NamedTuple, Generic[SceneT]):
    """Where an episode takes place, and where its goal was specified.

    Attributes:
        scene: the present one.
        goal_scene: the same object, or in the adaptation tasks another scene.
    """

    scene: SceneT
    goal_scene: SceneT


class Expert(Protocol):
    """A scripted policy that looks at the simulation's true state."""

    @property
    def done(self) -> bool:
        """Whether it has done what it set out to do, be that the task or not."""
        ...

    def act(self, gripper: FloatArray, points: FloatArray) -> Float64Array:
        """Gripper position (3,) [m] and object cloud (N, 3) [m] -> action (3,) in [-1, 1]."""
        ...


class Task(Protocol[SceneT]):
    """Scenes, physics, expert and score of one task. Stateless."""

    @property
    def env_id(self) -> str:
        """Id under which Gymnasium makes its environment."""
        ...

    @property
    def max_steps(self) -> int:
        """Control steps before an episode is truncated."""
        ...

    @property
    def ends_on_success(self) -> bool:
        """Whether an episode ends once success has held for ``HOLD_STEPS``.

        False where the way to one goal leads through states that are right for another: there the
        whole budget is played, and what holds at its end counts.
        """
        ...

    @property
    def action_scale(self) -> float:
        """[m] gripper translation per control step for an action of 1."""
        ...

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Keys of ``parameters``."""
        ...

    def draw_scenes(self, rng: np.random.Generator) -> Scenes[SceneT]:
        """Random scenes, not yet known to be solvable."""
        ...

    def make_plant(self, scene: SceneT) -> Plant:
        """The compiled scene, at rest in its start state."""
        ...

    def boxes(self, scene: SceneT) -> list[Box]:
        """Every solid part of the scene but the floor."""
        ...

    def make_expert(
        self, scene: SceneT, rng: np.random.Generator | None = None, *, noisy: bool = False
    ) -> Expert:
        """The scripted expert; ``noisy`` draws a style that is not always a good one."""
        ...

    def parameters(self, scene: SceneT) -> dict[str, Float64Array]:
        """What ``matches`` needs to know of a scene; it travels in ``info``."""
        ...

    def solved(self, points: Float32Array, scene: SceneT) -> BoolArray:
        """(N, 3) [m] -> (F,) which parts of the task are done, without any goal."""
        ...

    def matches(
        self, achieved: FloatArray, desired: FloatArray, info: Mapping[str, Any]
    ) -> BoolArray:
        """(B, N, 3) object and goal clouds, (B, ...) parameters -> (B, F) parts that match."""
        ...

    def canonical_cloud(self) -> Float32Array:
        """(N, 3) [m] the object in its rest frame."""
        ...


@dataclass(frozen=True)
class Demonstration:
    """One episode of the scripted expert.

    Attributes:
        points: (T, N, 3) float32 [m] object cloud at the start and after every step.
        actions: (T - 1, 3) float32.
        nodes: (T, P, 3) [m] tracked nodes, from which the cloud follows.
        gripper: (T, 6) float32 position [m] and velocity [m/s], as observed.
        solved: (T, F) which parts were done.
        success: whether every part was done and stayed so for ``HOLD_STEPS`` steps.
        complete_rate: share of the parts done at the end.
        diverged: whether the physics blew up.
    """

    points: Float32Array
    actions: Float32Array
    nodes: Float64Array
    gripper: Float32Array
    solved: BoolArray
    success: bool
    complete_rate: float
    diverged: bool

    @property
    def steps(self) -> int:
        """Control steps taken."""
        return len(self.actions)


def run_expert(
    task: Task[SceneT], scene: SceneT, plant: Plant, expert: Expert, steps: int | None = None
) -> Demonstration:
    """Let an expert act from the plant's present state until success holds or time is up.

    It also ends ``IDLE_STEPS`` after the expert is done, so that what it did instead of the task is
    a demonstration of that, not of waiting.

    Args:
        task: whose success counts.
        scene: what the plant was made from.
        plant: left in the last state.
        expert: acts on what an agent would observe.
        steps: control steps at most; None is the task's budget.
    """
    budget = task.max_steps if steps is None else steps
    nodes = [plant.nodes()]
    points = [plant.cloud(nodes[-1])]
    gripper = [plant.motion()]
    solved = [task.solved(points[-1], scene)]
    actions: list[Float32Array] = []
    held = idle = 0
    diverged = plant.diverged()
    while held < HOLD_STEPS and idle < IDLE_STEPS and len(actions) < budget and not diverged:
        # As observed, so that an agent can repeat it.
        action = expert.act(gripper[-1][:3], points[-1]).astype(np.float32)
        plant.step(action)
        actions.append(action)
        nodes.append(plant.nodes())
        points.append(plant.cloud(nodes[-1]))
        gripper.append(plant.motion())
        solved.append(task.solved(points[-1], scene))
        held = held + 1 if bool(solved[-1].all()) else 0
        idle = idle + 1 if expert.done else 0
        diverged = plant.diverged()
    return Demonstration(
        np.stack(points),
        np.array(actions, dtype=np.float32).reshape(-1, 3),
        np.stack(nodes),
        np.stack(gripper),
        np.stack(solved),
        held >= HOLD_STEPS and not diverged,
        0.0 if diverged else float(solved[-1].mean()),
        diverged,
    )
