"""States with known answers: a bar of twelve points goes round a wall at constant speed."""

from __future__ import annotations

import numpy as np

from icd_agent.latent.config import LatentConfig
from icd_agent.scene_tokens import SceneTokens
from icd_agent.states import EVERY, States
from icd_envs.api import Float32Array, FloatArray

CANONICAL = np.stack([np.linspace(0.0, 0.2, 12), np.zeros(12), np.zeros(12)], -1).astype(np.float32)
PACE = 0.005
"""[m] per control step."""
LATENT = LatentConfig(3, 4, 12, latent=8, groups=6, neighbours=4, width=16, decoder_width=16)


def along_the_way(metres: FloatArray, height: float = 0.2) -> FloatArray:
    """Places (..., 3) [m]: up, over the wall, and down again."""
    corners = np.cumsum([0.0, height, 0.4, height])
    x = np.interp(metres, corners, [-0.2, -0.2, 0.2, 0.2])
    y = np.interp(metres, corners, [0.0, height, height, 0.0])
    return np.stack([x, y, np.zeros_like(x)], axis=-1)


def bar_at(places: FloatArray) -> Float32Array:
    """Object clouds (..., 12, 3) at places (..., 3); the places are their features as well."""
    return (np.asarray(places)[..., None, :] + CANONICAL).astype(np.float32)


def toy_states(episodes: int = 30, seed: int = 0) -> States:
    """Episodes that begin anywhere on the first half of the way and end where it ends."""
    rng = np.random.default_rng(seed)
    steps, places = [], []
    for _ in range(episodes):
        begin = rng.uniform(0.0, 0.3)
        step = np.arange(0, int((0.8 - begin) / PACE) + 1, EVERY)
        steps.append(step)
        places.append(along_the_way(begin + PACE * step))
    lengths = [len(each) for each in steps]
    clouds = bar_at(np.concatenate(places))
    return States(
        features=clouds.astype(np.float16),
        clouds=clouds,
        middle=clouds.mean(axis=1),
        step=np.concatenate(steps),
        episode=np.repeat(np.arange(episodes), lengths),
        solved=np.zeros((sum(lengths), 1), bool),
        first=np.concatenate([[0], np.cumsum(lengths)]),
        success=np.ones(episodes, bool),
        tokens=SceneTokens(
            np.tile(np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 0.1]], np.float32), (episodes, 1, 1)),
            np.ones((episodes, 2, 4), np.float32),
        ),
        canonical=CANONICAL,
    )
