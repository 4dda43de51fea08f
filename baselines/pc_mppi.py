"""PC-MPPI: the goal as the only subgoal, distances in points, MPPI as in the paper."""

from __future__ import annotations

from icd_agent.chain import GoalSource, PointSpace
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker


def make_pc_mppi() -> SubgoalTracker:
    """Build the paper's baseline PC-MPPI."""
    return SubgoalTracker(GoalSource(), PointSpace(), preset("paper"))
