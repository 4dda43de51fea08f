"""When a cable passes a clip as the goal does: as often, and in the same sense."""

from __future__ import annotations

import numpy as np
import pytest

from icd_envs.scenes.clip import THROAT_X, throat_height
from icd_envs.tasks.cable_routing import CableRouting, CableRoutingAdaptation

MIDDLE = sum(THROAT_X) / 2
LOW = 0.4 * throat_height(MIDDLE)
BEFORE, BEHIND, BEYOND = (MIDDLE, -0.1), (MIDDLE, 0.1), THROAT_X[1] + 0.1
ROUND = [(BEYOND, 0.1), (BEYOND, -0.1)]
"""Past the clip's mouth, back to the side the cable came from."""

WAYS = {
    "not at all": [(BEYOND, -0.1), (BEYOND, 0.1)],
    "once": [BEFORE, BEHIND],
    "once, against the axis": [BEHIND, BEFORE],
    "through and back": [BEFORE, BEHIND, BEFORE],
    "twice round": [BEFORE, BEHIND, *ROUND, BEFORE, BEHIND],
    "twice round, against the axis": [BEHIND, BEFORE, *ROUND[::-1], BEHIND, BEFORE],
}
NET = dict(zip(WAYS, (0, 1, -1, 0, 2, -2), strict=True))
HERE, THERE = np.array([[0.0, 0.0, 0.0]]), np.array([[0.3, -0.2, np.pi / 2]])


def cable(way: str, clip: np.ndarray) -> np.ndarray:
    """(n, 3) polyline that passes a clip in one of ``WAYS``."""
    x, y = np.array(WAYS[way]).T
    cos, sin = np.cos(clip[2]), np.sin(clip[2])
    low = np.full(len(x), LOW)
    return np.stack([clip[0] + cos * x - sin * y, clip[1] + sin * x + cos * y, low], axis=-1)


@pytest.mark.parametrize("goal", WAYS)
@pytest.mark.parametrize("way", WAYS)
def test_clip_is_matched_when_it_is_passed_as_often_and_in_the_same_sense(
    way: str, goal: str
) -> None:
    achieved = cable(way, HERE[0])[None]
    info = {"clips": HERE[None], "goal_clips": HERE[None]}
    matched = CableRouting(1).matches(achieved, cable(goal, HERE[0])[None], info)
    assert matched.tolist() == [[NET[way] == NET[goal]]]
    elsewhere = {"clips": HERE[None], "goal_clips": THERE[None]}
    task = CableRoutingAdaptation(1)
    there = task.matches(achieved, cable(goal, THERE[0])[None], elsewhere)
    assert there.tolist() == matched.tolist()
