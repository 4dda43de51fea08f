"""Features of recorded states, computed once and kept on disk, for everything trained on them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from icd_agent.chain import Features
from icd_agent.episodes import sound_episodes
from icd_agent.kept import KINDS, Arrays, Kept
from icd_agent.locking import alone
from icd_agent.scene_tokens import TOKENS, Frame, SceneTokens
from icd_envs.api import BoolArray, Float32Array
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError

EVERY: Final = 5
"""Control steps between states that are kept."""
SAVE_EVERY: Final = 50
"""Episodes between states that a killed call can go on from."""
ELSEWHERE: Final = "copy the demonstrations to a folder of your own"

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

    Episodes whose physics diverged are left out.

    Args:
        demonstrations: states.
        describe: the cost space.
        folder: where the features are kept; one call at a time fills it.
        space: names the cost space and its weights; what is kept of another one is refused.
        episodes: how many are used, at most.
        seen: is told the number of episodes done.

    Raises:
        DemonstrationsError: ``folder`` has the features of something else, is damaged, cannot be
            written, or is being filled by another call; or all episodes diverged.
    """
    used = sound_episodes(demonstrations, episodes)
    rows = [_rows(demonstrations, int(i)) for i in used]
    first = np.concatenate([[0], np.cumsum([len(each) for each in rows])])
    nodes = np.concatenate(rows)
    poses = hashlib.sha256(demonstrations.nodes[nodes].tobytes()).hexdigest()
    identity = {
        "space": space,
        "env": demonstrations.header.env_id,
        "poses": poses,
        "every": EVERY,
        "tokens": TOKENS,
        "kept": list(KINDS),
    }
    canonical = demonstrations.canonical_cloud
    on_disk = Kept(folder, identity, len(used), len(nodes), len(canonical))
    if on_disk.done() < len(used):  # what is complete never changes: it needs no lock
        with alone(folder, "training", DemonstrationsError, ELSEWHERE):
            _fill(on_disk, demonstrations, describe, used, rows, seen)
    kept = on_disk.read()
    steps = np.concatenate(
        [each - demonstrations.first_state[i] for i, each in zip(used, rows, strict=True)]
    )
    return States(
        features=kept["features"],
        clouds=kept["clouds"],
        middle=np.concatenate([part.mean(axis=1) for part in np.array_split(kept["clouds"], 100)]),
        step=steps,
        episode=np.repeat(np.arange(len(used)), np.diff(first)),
        solved=demonstrations.solved[nodes],
        first=first,
        success=demonstrations.success[used],
        tokens=SceneTokens(np.array(kept["places"]), np.array(kept["scene"])),
        canonical=canonical,
    )


def _fill(
    on_disk: Kept,
    demonstrations: Demonstrations,
    describe: Describe,
    used: NDArray[np.int64],
    rows: list[NDArray[np.int64]],
    seen: Callable[[int], None],
) -> None:
    """Describe the episodes that are not there yet."""
    ends = np.cumsum([len(each) for each in rows])
    done = on_disk.done()
    arrays: Arrays = {}
    for i in range(done, len(used)):
        features, tokens = describe(demonstrations.scene(int(used[i])).cloud)
        clouds = demonstrations.points(demonstrations.nodes[rows[i]])
        new = {"features": features(clouds), "clouds": clouds}
        still = {"places": tokens.places, "scene": tokens.features}
        if not arrays:
            shapes = {name: array.shape[1:] for name, array in new.items()}
            shapes |= {name: array.shape for name, array in still.items()}
            arrays = on_disk.reopen(shapes) if done else on_disk.create(shapes)
        for name, array in new.items():
            arrays[name][ends[i] - len(rows[i]) : ends[i]] = array
        for name, array in still.items():
            arrays[name][i] = array
        if (i + 1) % SAVE_EVERY == 0 or i + 1 == len(used):
            on_disk.save(arrays, i + 1)
            seen(i + 1)


def _rows(demonstrations: Demonstrations, i: int) -> NDArray[np.int64]:
    """Rows of the states that are kept of one episode; the last state is one of them."""
    first, end = demonstrations.first_state[i : i + 2]
    return np.unique(np.append(np.arange(first, end, EVERY), end - 1))
