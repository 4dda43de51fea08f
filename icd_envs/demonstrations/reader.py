"""Read recorded demonstrations: states from the shards, scenes drawn again from the seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from icd_envs.api import BoolArray, Float32Array, Float64Array
from icd_envs.demonstrations.experts import find_task
from icd_envs.demonstrations.header import Header, read_header, shard_path
from icd_envs.demonstrations.shard import PARAMETER, Arrays, read_shard
from icd_envs.errors import DemonstrationsError
from icd_envs.scenes.boxes import Box
from icd_envs.tasks.base import Task
from icd_envs.tasks.observation import sample_boxes
from icd_envs.tasks.problem import scene_rng


@dataclass(frozen=True)
class RecordedEpisode:
    """One episode of T control steps; state t + 1 follows from action t.

    Attributes:
        index: number of the episode.
        seed: fixes the scene and every draw of the expert.
        points: (T + 1, N, 3) [m] object cloud.
        nodes: (T + 1, P, 3) [m] tracked nodes, from which the cloud follows.
        gripper: (T + 1, 6) position [m] and velocity [m/s], as an agent observes them.
        solved: (T + 1, F) which parts of the task were done.
        actions: (T, 3) in [-1, 1].
        success: every part was done and stayed so until the end.
        diverged: the physics blew up after the last state.
    """

    index: int
    seed: int
    points: Float32Array
    nodes: Float32Array
    gripper: Float32Array
    solved: BoolArray
    actions: Float32Array
    success: bool
    diverged: bool

    @property
    def steps(self) -> int:
        """Control steps."""
        return len(self.actions)


@dataclass(frozen=True)
class RecordedScene:
    """The scene of one episode, drawn again.

    Attributes:
        scene: the task's own description.
        boxes: every solid part but the floor.
        cloud: (1000, 3) float32 [m], the scene cloud that the environment shows for this seed.
    """

    scene: Any
    boxes: list[Box]
    cloud: Float32Array


class Demonstrations:
    """All episodes of a folder, in memory.

    Arrays of different episodes stand one after another, so that training code can draw states
    without a loop: state t of episode i is row ``first_state[i] + t`` of ``nodes``, ``gripper``
    and ``solved``; its action is row ``first_step[i] + t`` of ``actions``.

    Attributes:
        header: what is the same for all episodes.
        index: (E,) number of each episode; 0 ... E - 1 unless the folder is incomplete.
        seeds: (E,) int64.
        lengths: (E,) control steps of each episode.
        success: (E,) every part was done and stayed so.
        diverged: (E,) the physics blew up after the last state.
        first_step: (E + 1,) offsets into ``actions``.
        first_state: (E + 1,) offsets into ``nodes``, ``gripper`` and ``solved``.
        nodes: (sum of T + 1, P, 3) float32 [m].
        gripper: (sum of T + 1, 6) float32 [m, m/s].
        solved: (sum of T + 1, F) bool.
        actions: (sum of T, 3) float32.
    """

    def __init__(self, folder: Path | str, *, partial: bool = False) -> None:
        """Read a folder that ``icd-bench collect`` has filled.

        Args:
            folder: where it is.
            partial: also accept a folder that is still being filled.

        Raises:
            DemonstrationsError: missing, incomplete or damaged; names the file.
        """
        folder = Path(folder)
        self.header: Header = read_header(folder)
        shards, index = _read_shards(folder, self.header, partial=partial)
        self.index: NDArray[np.int64] = index
        # Popped one by one, so that parts and whole are not both in memory.
        whole = {name: _join(shards, name) for name in tuple(shards[0])}
        self.seeds: NDArray[np.int64] = whole["seeds"]
        self.lengths: NDArray[np.int64] = whole["lengths"].astype(np.int64)
        self.success: BoolArray = whole["success"]
        self.diverged: BoolArray = whole["diverged"]
        self.nodes: Float32Array = whole["nodes"]
        self.gripper: Float32Array = whole["gripper"]
        self.solved: BoolArray = whole["solved"]
        self.actions: Float32Array = whole["actions"]
        self.first_step = np.concatenate([[0], np.cumsum(self.lengths)])
        self.first_state = np.concatenate([[0], np.cumsum(self.lengths + 1)])
        self._scene_ids = whole["scene_ids"]
        self._parameters = {
            name.removeprefix(PARAMETER): array
            for name, array in whole.items()
            if name.startswith(PARAMETER)
        }
        # Data do not say what to import: whoever reads those of their own task imports it before.
        env_id = self.header.env_id.rpartition(":")[2]
        self._task: Task[Any] = find_task(env_id, self.header.options)

    def __len__(self) -> int:
        """Number of episodes."""
        return len(self.lengths)

    def __iter__(self) -> Iterator[RecordedEpisode]:
        """All episodes, in order."""
        return map(self.episode, range(len(self)))

    def episode(self, i: int) -> RecordedEpisode:
        """The i-th episode that is here."""
        states = slice(self.first_state[i], self.first_state[i + 1])
        nodes = self.nodes[states]
        return RecordedEpisode(
            index=int(self.index[i]),
            seed=int(self.seeds[i]),
            points=self.points(nodes),
            nodes=nodes,
            gripper=self.gripper[states],
            solved=self.solved[states],
            actions=self.actions[self.first_step[i] : self.first_step[i + 1]],
            success=bool(self.success[i]),
            diverged=bool(self.diverged[i]),
        )

    @property
    def canonical_cloud(self) -> Float32Array:
        """(N, 3) [m] the object in its own rest frame, same point order as every cloud."""
        return self._task.canonical_cloud()

    def points(self, nodes: Float32Array) -> Float32Array:
        """(..., P, 3) tracked nodes [m] -> (..., N, 3) float32 object clouds [m].

        Nodes are stored in single precision: a cloud is that of the episode within 1e-7 m.
        """
        return self._cloud(nodes.astype(np.float64))

    def scene(self, i: int) -> RecordedScene:
        """The scene of the i-th episode, drawn again from its seed.

        Raises:
            DemonstrationsError: this version of the task draws another scene from the seed.
        """
        rng = scene_rng(self.header.split, int(self.seeds[i]))
        scene = self._task.draw_scenes(rng).scene
        if not self.same_scene(i, self._task.parameters(scene)):
            raise self._another_version(i, "scene")
        boxes = self._task.boxes(scene)
        return RecordedScene(scene, boxes, sample_boxes(boxes, rng))

    def same_scene(self, i: int, parameters: Mapping[str, Any]) -> bool:
        """Whether a scene's parameters, by name, are those of the i-th episode."""
        return all(
            name in parameters and np.array_equal(recorded[i], parameters[name])
            for name, recorded in self._parameters.items()
        )

    def replay(self, i: int) -> Float32Array:
        """(T + 1, N, 3) object cloud of the i-th episode, simulated again: exact to the bit.

        Raises:
            DemonstrationsError: this version of the task simulates something else.
        """
        plant = self._task.make_plant(self.scene(i).scene)
        if plant.scene_id.encode() != self._scene_ids[i]:
            raise self._another_version(i, "compiled scene")
        nodes = [plant.nodes()]
        for action in self.actions[self.first_step[i] : self.first_step[i + 1]]:
            plant.step(action)
            nodes.append(plant.nodes())
        replayed = np.stack(nodes)
        recorded = self.nodes[self.first_state[i] : self.first_state[i + 1]]
        if not np.array_equal(replayed.astype(np.float32), recorded):
            raise self._another_version(i, "motion")
        return self._cloud(replayed)

    @cached_property
    def _cloud(self) -> Callable[[Float64Array], Float32Array]:
        # It is the same for all scenes; compiling one takes about 0.1 s.
        scene = self._task.draw_scenes(scene_rng(self.header.split, int(self.seeds[0]))).scene
        return self._task.make_plant(scene).cloud

    def _another_version(self, i: int, what: str) -> DemonstrationsError:
        return DemonstrationsError(
            f"episode {self.index[i]}, seed {self.seeds[i]}: the {what} differs from the recorded "
            f"one: use the version of {self.header.env_id} and of MuJoCo that it was recorded with"
        )


def _read_shards(
    folder: Path, header: Header, *, partial: bool
) -> tuple[list[Arrays], NDArray[np.int64]]:
    shards, indices = [], []
    for number in range(header.shards):
        path, wanted = shard_path(folder, number), header.indices(number)
        if partial and not path.exists():
            continue
        arrays = read_shard(path)
        got = len(arrays["lengths"])
        if got > len(wanted) or (got < len(wanted) and not partial):
            raise DemonstrationsError(
                f"{path} has {got} episodes instead of {len(wanted)}: go on collecting"
            )
        shards.append(arrays)
        indices.append(np.array(wanted[:got]))
    if not shards:
        raise DemonstrationsError(f"{folder} has no finished shard yet")
    return shards, np.concatenate(indices)


def _join(shards: list[Arrays], name: str) -> NDArray[Any]:
    parts = [arrays.pop(name, np.empty(0)) for arrays in shards]
    try:
        return np.concatenate(parts)
    except ValueError as error:
        raise DemonstrationsError(f"the shards are of different scenes: {name}: {error}") from error
