"""PC-MPPI: the goal as the only subgoal, distances in points."""

from __future__ import annotations

from icd_agent.chain import GoalSource, PointSpace
from icd_agent.mppi.presets import PAPER
from icd_agent.presets import PRESETS, best_preset
from icd_agent.tracking import SubgoalTracker


def make_pc_mppi() -> SubgoalTracker:
    """Build the paper's baseline PC-MPPI, with the paper's MPPI."""
    return SubgoalTracker(GoalSource(), PointSpace(), PAPER)


def make_pc_mppi_improved(env_id: str) -> SubgoalTracker:
    """Build it with ICD's planner: what it lacks then is the chain, and descriptors."""
    return SubgoalTracker(GoalSource(), PointSpace(), PRESETS[best_preset(env_id)].mppi)
