"""What a task is: the parts of an environment that differ from task to task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Generic, Literal, Protocol, TypeVar

import numpy as np

from icd_envs.api import BoolArray, Float32Array, Float64Array, FloatArray, Oracle
from icd_envs.errors import InvalidOptionError, InvalidSeedError, SceneGenerationError
from icd_envs.physics.guard import BOUND
from icd_envs.physics.plant import Plant
from icd_envs.scenes.boxes import Box

Split = Literal["train", "test"]
SPLITS: Final[tuple[Split, ...]] = ("train", "test")

HOLD_STEPS: Final = 10
"""Control steps for which success must hold before an episode ends."""
MAX_ATTEMPTS: Final = 20
"""Scenes drawn for one seed before giving up on finding one that the expert solves."""
SEED_LIMIT: Final = 2**64
"""Minari's collector draws seeds of 64 bits."""

SceneT = TypeVar("SceneT")


class Expert(Protocol):
    """A scripted policy that looks at the simulation's true state."""

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
    def action_scale(self) -> float:
        """[m] gripper translation per control step for an action of 1."""
        ...

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Keys of ``parameters``."""
        ...

    def draw_scene(self, rng: np.random.Generator) -> SceneT:
        """A random scene, not yet known to be solvable."""
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
    gripper = [_gripper(plant)]
    solved = [task.solved(points[-1], scene)]
    actions: list[Float32Array] = []
    held = 0
    diverged = plant.diverged()
    while held < HOLD_STEPS and len(actions) < budget and not diverged:
        # As observed, so that an agent can repeat it.
        action = expert.act(gripper[-1][:3], points[-1]).astype(np.float32)
        plant.step(action)
        actions.append(action)
        nodes.append(plant.nodes())
        points.append(plant.cloud(nodes[-1]))
        gripper.append(_gripper(plant))
        solved.append(task.solved(points[-1], scene))
        held = held + 1 if bool(solved[-1].all()) else 0
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


def _gripper(plant: Plant) -> Float32Array:
    motion = np.concatenate([plant.gripper(), plant.gripper_velocity()])
    return np.asarray(np.clip(motion, -BOUND, BOUND), dtype=np.float32)


@dataclass(frozen=True)
class Problem(Generic[SceneT]):
    """A scene with its start state and a way to solve it.

    Attributes:
        scene: what was drawn.
        plant: compiled scene, in its start state.
        oracle: how the expert solved it; the goal is its last cloud.
    """

    scene: SceneT
    plant: Plant
    oracle: Oracle


def draw_problem(task: Task[SceneT], rng: np.random.Generator, seed: int) -> Problem[SceneT]:
    """Draw scenes until the clean expert solves one.

    Raises:
        SceneGenerationError: if none of ``MAX_ATTEMPTS`` scenes was solved.
    """
    for _ in range(MAX_ATTEMPTS):
        scene = task.draw_scene(rng)
        plant = task.make_plant(scene)
        start = plant.get_state()
        demonstration = run_expert(task, scene, plant, task.make_expert(scene))
        if demonstration.success:
            plant.set_state(start)
            oracle = Oracle(scene, demonstration.points, demonstration.actions)
            return Problem(scene, plant, oracle)
    raise SceneGenerationError(
        f"{task.env_id}: the expert solved none of {MAX_ATTEMPTS} scenes drawn with seed {seed}: "
        "use another seed"
    )


def scene_rng(split: Split, seed: int) -> np.random.Generator:
    """Generator of everything random in an episode; splits never share a stream."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(SPLITS.index(split),)))


def sensor_rng(split: Split, seed: int, step: int) -> np.random.Generator:
    """Generator of a sensor's noise at one step: it depends on nothing else that happened."""
    key = (SPLITS.index(split), step)  # longer than a scene's key: never the same stream
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def check_seed(seed: object) -> int:
    """A reset seed as an int.

    Raises:
        InvalidSeedError: if it is not an integer in [0, 2**64).
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise InvalidSeedError(
            f"seed must be an integer in [0, {SEED_LIMIT}), got {seed!r} of type "
            f"{type(seed).__name__}: pass e.g. seed=0"
        )
    if not 0 <= int(seed) < SEED_LIMIT:
        raise InvalidSeedError(f"seed must be in [0, {SEED_LIMIT}), got {seed}: pass e.g. seed=0")
    return int(seed)


def check_integer(name: str, value: object, low: int, high: int) -> None:
    """Refuse what is not an integer in [low, high].

    Raises:
        InvalidOptionError: naming option, value and range.
    """
    if type(value) is not int or not low <= value <= high:
        raise InvalidOptionError(f"{name} must be an integer in [{low}, {high}], got {value!r}")


def check_choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    """Refuse a value that is not one of ``choices``.

    Raises:
        InvalidOptionError: naming option, value and choices.
    """
    from icd_envs.errors import unknown_name

    if value not in choices:
        raise InvalidOptionError(unknown_name(f"value of {name!r}:", value, choices))
