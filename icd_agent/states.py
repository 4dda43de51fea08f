"""Features of recorded states, computed once and kept on disk, for everything trained on them."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.lib.format import open_memmap
from numpy.typing import NDArray

from icd_agent.chain import Features
from icd_agent.scene_tokens import TOKENS, Frame, SceneTokens
from icd_envs.api import BoolArray, Float32Array
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError

EVERY: Final = 5
"""Control steps between states that are kept."""
SAVE_EVERY: Final = 50
"""Episodes between states that a killed call can go on from."""
PROGRESS: Final = "states.json"
KEPT: Final = ("features", "clouds", "places", "scene")

Describe = Callable[[Float32Array], tuple[Features, SceneTokens]]
"""Makes the features and the tokens of a scene from its cloud (M, 3) [m]."""


class States(NamedTuple):
    """Every fifth state of many episodes; those of episode i are rows first[i] to first[i + 1].

    Attributes:
        features: (S, N, D) float16 of the cost space, on disk.
        clouds: (S, N, 3) float32 [m] the object, on disk.
        middle: (S, 3) float32 [m] mean of its points.
        step: (S,) control step of each state.
        episode: (S,) index of its episode.
        solved: (S, F) bool, parts of the task that are done.
        first: (E + 1,) offsets.
        success: (E,) every part was done and stayed so.
        tokens: of the scenes, (E, A, ...).
        canonical: (N, 3) [m] the object in its rest frame.
    """

    features: NDArray[np.float16]
    clouds: Float32Array
    middle: Float32Array
    step: NDArray[np.int64]
    episode: NDArray[np.int64]
    solved: BoolArray
    first: NDArray[np.int64]
    success: BoolArray
    tokens: SceneTokens
    canonical: Float32Array

    def draw(self, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Rows of so many states, or of all, in order."""
        count = min(count, len(self.step))
        return np.sort(rng.choice(len(self.step), count, replace=False))

    def frame(self, rows: NDArray[np.int64]) -> Frame:
        """Frames in which scene and object are seen from these states (B,)."""
        where = self.episode[rows]
        tokens = SceneTokens(self.tokens.places[where], self.tokens.features[where])
        return tokens.frame(self.middle[rows])

    def seen_from(self, rows: NDArray[np.int64], size: float) -> Float32Array:
        """Scene tokens of these states (B,), in frames given by them: (B, A, 3 + D).

        Args:
            rows: of states.
            size: [m] unit of places.
        """
        where = self.episode[rows]
        tokens = SceneTokens(self.tokens.places[where], self.tokens.features[where])
        return tokens.seen_from(self.middle[rows], size)


def describe_states(
    demonstrations: Demonstrations,
    describe: Describe,
    folder: Path,
    *,
    space: str,
    episodes: int,
    seen: Callable[[int], None] = lambda done: None,
) -> States:
    """Compute features, or go on where a killed call stopped, or read what is there.

    Args:
        demonstrations: states.
        describe: the cost space.
        folder: where the features are kept.
        space: names the cost space and its weights; what is kept of another one is refused.
        episodes: how many are used, at most.
        seen: is told the number of episodes done.

    Raises:
        DemonstrationsError: ``folder`` has the features of something else.
    """
    count = min(episodes, len(demonstrations))
    rows = [_rows(demonstrations, i) for i in range(count)]
    first = np.concatenate([[0], np.cumsum([len(each) for each in rows])])
    nodes = np.concatenate(rows)
    poses = hashlib.sha256(demonstrations.nodes[nodes].tobytes()).hexdigest()
    identity = {
        "space": space,
        "env": demonstrations.header.env_id,
        "poses": poses,
        "every": EVERY,
        "tokens": TOKENS,
        "kept": list(KEPT),
    }
    folder.mkdir(parents=True, exist_ok=True)
    done = _progress(folder, identity)
    arrays: dict[str, Any] = {}
    for i in range(done, count):
        features, tokens = describe(demonstrations.scene(i).cloud)
        clouds = demonstrations.points(demonstrations.nodes[rows[i]])
        found = features(clouds)
        if not arrays:
            shapes = {
                "features": (np.float16, (int(first[-1]), *found.shape[1:])),
                "clouds": (np.float32, (int(first[-1]), *clouds.shape[1:])),
                "places": (np.float32, (count, *tokens.places.shape)),
                "scene": (np.float32, (count, *tokens.features.shape)),
            }
            arrays = {
                name: open_memmap(folder / f"{name}.npy", "r+" if done else "w+", kind, size)
                for name, (kind, size) in shapes.items()
            }
        arrays["features"][first[i] : first[i + 1]] = found
        arrays["clouds"][first[i] : first[i + 1]] = clouds
        arrays["places"][i], arrays["scene"][i] = tokens
        if (i + 1) % SAVE_EVERY == 0 or i + 1 == count:
            for array in arrays.values():
                array.flush()
            _write(folder / PROGRESS, {**identity, "done": i + 1})
            seen(i + 1)
    kept = {name: np.load(folder / f"{name}.npy", mmap_mode="r") for name in KEPT}
    steps = np.concatenate([each - demonstrations.first_state[i] for i, each in enumerate(rows)])
    return States(
        features=kept["features"],
        clouds=kept["clouds"],
        middle=np.concatenate([part.mean(axis=1) for part in np.array_split(kept["clouds"], 100)]),
        step=steps,
        episode=np.repeat(np.arange(count), np.diff(first)),
        solved=demonstrations.solved[nodes],
        first=first,
        success=demonstrations.success[:count],
        tokens=SceneTokens(np.array(kept["places"]), np.array(kept["scene"])),
        canonical=demonstrations.canonical_cloud,
    )


def _rows(demonstrations: Demonstrations, i: int) -> NDArray[np.int64]:
    """Rows of the states that are kept of one episode; the last state is one of them."""
    first, end = demonstrations.first_state[i : i + 2]
    return np.unique(np.append(np.arange(first, end, EVERY), end - 1))


def _progress(folder: Path, identity: dict[str, Any]) -> int:
    path = folder / PROGRESS
    if not path.exists():
        return 0
    record = json.loads(path.read_text(encoding="utf-8"))
    done = record.pop("done")
    if record != identity:
        raise DemonstrationsError(
            f"{folder} has features of other states or of another space: delete it, or name another"
        )
    return int(done)


def _write(path: Path, record: dict[str, Any]) -> None:
    beside = path.with_suffix(".new")
    beside.write_text(json.dumps(record), encoding="utf-8")
    os.replace(beside, path)
