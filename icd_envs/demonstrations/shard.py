"""A shard: a few episodes in one uncompressed npz file, without pickle.

Arrays of different episodes stand one after another; ``lengths`` says where each begins. The zip
container keeps a CRC of every array, so that damage is noticed on reading. Equal episodes give
equal bytes.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from icd_envs.api import BoolArray, Float32Array, Float64Array
from icd_envs.errors import DemonstrationsError

Arrays = dict[str, NDArray[Any]]

PARAMETER: Final = "parameter_"
"""Prefix of a scene parameter's name in a shard."""
NAMES: Final = "names_of_parameters"
"""Array of these names: a zip whose directory is damaged can lose a whole array without a word."""

FIELDS: Final[dict[str, tuple[str, Literal["episode", "step", "state"], tuple[int, ...]]]] = {
    "seeds": ("<i8", "episode", ()),
    "lengths": ("<i4", "episode", ()),
    "success": ("|b1", "episode", ()),
    "diverged": ("|b1", "episode", ()),
    "scene_ids": ("|S16", "episode", ()),
    "nodes": ("<f4", "state", (-1, 3)),
    "gripper": ("<f4", "state", (6,)),
    "solved": ("|b1", "state", (-1,)),
    "actions": ("<f4", "step", (3,)),
}
"""Type, rows (one per episode, per control step, or per state) and shape of a row; -1 is any."""


@dataclass(frozen=True)
class Recording:
    """One episode of T control steps, as it is stored.

    Attributes:
        seed: fixes the scene and every draw of the expert.
        scene_id: fingerprint of the compiled scene.
        parameters: of the scene, see ``Task.parameters``.
        nodes: (T + 1, P, 3) [m] tracked nodes.
        gripper: (T + 1, 6) position [m] and velocity [m/s].
        solved: (T + 1, F) which parts were done.
        actions: (T, 3) in [-1, 1].
        success: every part was done and stayed so.
        diverged: the physics blew up; the record ends before that.
    """

    seed: int
    scene_id: str
    parameters: dict[str, Float64Array]
    nodes: Float32Array
    gripper: Float32Array
    solved: BoolArray
    actions: Float32Array
    success: bool
    diverged: bool


def encode(recordings: Sequence[Recording]) -> bytes:
    """The file's content.

    Args:
        recordings: at least one, all of one environment.
    """
    arrays: Arrays = {
        "seeds": np.array([r.seed for r in recordings]),
        "lengths": np.array([len(r.actions) for r in recordings]),
        "success": np.array([r.success for r in recordings]),
        "diverged": np.array([r.diverged for r in recordings]),
        "scene_ids": np.array([r.scene_id.encode() for r in recordings]),
        "nodes": np.concatenate([r.nodes for r in recordings]),
        "gripper": np.concatenate([r.gripper for r in recordings]),
        "solved": np.concatenate([r.solved for r in recordings]),
        "actions": np.concatenate([r.actions for r in recordings]),
    }
    arrays = {name: array.astype(FIELDS[name][0]) for name, array in arrays.items()}
    arrays[NAMES] = np.array([name.encode() for name in recordings[0].parameters])
    for name in recordings[0].parameters:
        stacked = np.stack([r.parameters[name] for r in recordings])
        arrays[PARAMETER + name] = stacked.astype("<f8")
    content = io.BytesIO()
    np.savez(content, **arrays)  # type: ignore[arg-type]  # no array is called allow_pickle
    return content.getvalue()


def read_shard(path: Path) -> Arrays:
    """Read and check one shard.

    Returns:
        The arrays of ``FIELDS`` and one per scene parameter.

    Raises:
        DemonstrationsError: missing, damaged or not a shard; names the file.
    """
    fix = "delete it and go on collecting with the command that made it"
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: np.asarray(file[name]) for name in file.files}
    except FileNotFoundError as error:
        raise DemonstrationsError(f"{path} is missing: go on collecting") from error
    except Exception as error:  # zip, zlib, npy header: each fails in ways of its own
        raise DemonstrationsError(f"{path} is damaged: {error}: {fix}") from error
    if wrong := _mistake(arrays):
        raise DemonstrationsError(f"{path} is not a shard: {wrong}: {fix}")
    return arrays


def _mistake(arrays: Arrays) -> str:
    """What is wrong with a shard's arrays, or nothing."""
    names = arrays.get(NAMES, np.empty(0, "|S1"))
    if names.ndim != 1 or names.dtype.kind != "S":
        return f"{NAMES} has shape {names.shape} and type {names.dtype}"
    parameters = {PARAMETER + name.decode("ascii", "replace") for name in names}
    if different := {*FIELDS, NAMES, *parameters} ^ set(arrays):
        return f"missing or unknown arrays: {', '.join(sorted(different))}"
    lengths = arrays["lengths"]
    if lengths.ndim != 1 or lengths.dtype != "<i4" or np.any(lengths < 0):
        return "lengths must be (E,) int32, none negative"
    episodes, steps = len(lengths), int(lengths.sum())
    rows = {"episode": episodes, "step": steps, "state": steps + episodes}
    for name, (dtype, per, shape) in FIELDS.items():
        array = arrays[name]
        fits = array.ndim == 1 + len(shape) and all(
            wanted in (-1, got) for wanted, got in zip(shape, array.shape[1:], strict=True)
        )
        if array.dtype != dtype or not fits or len(array) != rows[per]:
            return f"{name} has shape {array.shape} and type {array.dtype}"
    for name in parameters:
        if arrays[name].dtype != "<f8" or len(arrays[name]) != episodes:
            return f"{name} has shape {arrays[name].shape} and type {arrays[name].dtype}"
    return ""
