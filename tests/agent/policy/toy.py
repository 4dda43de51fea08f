"""Recorded episodes with known answers: a hand goes straight to its goal, on one of six sides."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from icd_agent.policy.config import PolicyConfig
from icd_envs.api import Float32Array, FloatArray
from tests.agent.field.small import scene

POINTS = PolicyConfig(
    "points", 0, 4, 8, horizon=8, executed=4, widths=(16, 32), encoded=16, time_width=16
)
STRIDE = 0.02
"""[m] of an action of 1."""
NODES = 3


def cloud(nodes: FloatArray) -> Float32Array:
    """(..., 3, 3) nodes -> (..., 5, 3) points: the nodes, and what lies half-way."""
    between = (nodes[..., :-1, :] + nodes[..., 1:, :]) / 2
    found = np.empty((*nodes.shape[:-2], 5, 3), np.float32)
    found[..., 0::2, :], found[..., 1::2, :] = nodes, between
    return found


class Recorded(SimpleNamespace):
    """Has as many episodes as it has lengths."""

    def __len__(self) -> int:
        return len(self.lengths)


def toy_demonstrations(episodes: int = 6, seed: int = 0) -> Any:  # noqa: ANN401  a stand-in
    """What ``Demonstrations`` offers to those who learn from it."""
    rng = np.random.default_rng(seed)
    gripper, nodes, actions, lengths = [], [], [], []
    for _ in range(episodes):
        begin = rng.uniform(-0.05, 0.05, 3)
        goal = rng.uniform(-0.05, 0.05, 3)
        goal[rng.integers(3)] = rng.choice([-0.3, 0.3])
        steps = int(np.ceil(np.abs(goal - begin).max() / STRIDE))
        way = np.linspace(begin, goal, steps + 1)
        gripper.append(np.concatenate([way, np.zeros_like(way)], axis=1))
        nodes.append(way[:, None] + np.linspace(0.0, 0.1, NODES)[:, None])
        actions.append(np.diff(way, axis=0) / STRIDE)
        lengths.append(steps)
    first = np.concatenate([[0], np.cumsum(lengths)])
    solved = np.zeros((int(first[-1]) + episodes, 1), bool)
    ends = first[1:] + np.arange(episodes)
    solved[ends, 0] = np.arange(episodes) % 2 == 0
    clouds = [scene(i % 3).cloud for i in range(episodes)]
    return Recorded(
        lengths=np.array(lengths),
        first_step=first,
        first_state=first + np.arange(episodes + 1),
        gripper=np.concatenate(gripper).astype(np.float32),
        nodes=np.concatenate(nodes).astype(np.float32),
        actions=np.concatenate(actions).astype(np.float32),
        solved=solved,
        success=solved[ends, 0],
        diverged=np.zeros(episodes, bool),
        points=cloud,
        scene=lambda i: SimpleNamespace(cloud=clouds[i]),
    )
