"""The dense reward has the values that its definition gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from icd_envs.scenes.clip import THROAT_X, throat_height
from tests.envs.making import make

NOTEBOOK = "ICDNotebookFolding-v0"
TABLE = {"table": np.zeros(6), "goal_table": np.zeros(6)}
MIDDLE = sum(THROAT_X) / 2
LOW = 0.4 * throat_height(MIDDLE)
CLIPS = np.array([[0.0, -0.3, 0.0], [0.0, 0.3, 0.0]])


def routed_cable() -> np.ndarray:
    """(200, 3) straight along y, through the throats of both ``CLIPS``."""
    cable = np.tile([MIDDLE, 0.0, LOW], (200, 1))
    cable[:, 1] = np.linspace(-0.5, 0.5, 200)
    return cable


@pytest.mark.parametrize(
    ("distance", "expected"),
    [(0.0, 0.0), (0.02, -0.02), (0.049, -0.049), (0.051, -1.051), (0.1, -1.1)],
)
def test_notebook_pays_its_mean_distance_and_one_more_from_5_cm_on(
    distance: float, expected: float
) -> None:
    env = make(NOTEBOOK, reward_type="dense")
    goal = env.task.canonical_cloud().astype(float)
    shift = [distance, 0.0, 0.0]
    assert env.compute_reward(goal + shift, goal, TABLE) == pytest.approx(expected, abs=1e-12)


def test_distance_is_the_mean_over_the_points_of_each_cloud() -> None:
    env = make(NOTEBOOK, reward_type="dense")
    goal = env.task.canonical_cloud().astype(float)
    bent, moved = goal.copy(), goal + np.array([0.0, 0.3, 0.4])
    bent[: len(goal) // 4] += [0.0, 0.0, 0.08]
    rewards = env.compute_reward(np.stack([bent, moved]), np.stack([goal, goal]), [TABLE, TABLE])
    np.testing.assert_allclose(rewards, [-0.02, -1.5], atol=1e-12)


@pytest.mark.parametrize("env_id", ["ICDCableRouting-v0", "ICDCableRoutingAdaptation-v0"])
def test_cable_pays_its_mean_distance_and_the_share_of_clips_it_misses(env_id: str) -> None:
    env = make(env_id, reward_type="dense")
    goal, lifted = routed_cable(), routed_cable()
    lifted[100:, 2] += 0.2  # over the second clip
    info: dict[str, Any] = {"clips": CLIPS, "goal_clips": CLIPS}
    assert env.compute_reward(goal, goal, info) == pytest.approx(0.0, abs=1e-12)
    assert env.compute_reward(lifted, goal, info) == pytest.approx(0.5 - 1.0 - 0.1, abs=1e-12)
    above = goal + np.array([0.0, 0.0, 0.2])
    assert env.compute_reward(above, goal, info) == pytest.approx(0.0 - 1.0 - 0.2, abs=1e-12)
