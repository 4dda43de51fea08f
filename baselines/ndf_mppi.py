"""NDF-MPPI: the goal as the only subgoal, distances in descriptors."""

from __future__ import annotations

from icd_agent.chain import GoalSource
from icd_agent.field.space import FieldSpace
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker


def make_ndf_mppi(env_id: str) -> SubgoalTracker:
    """Build the paper's baseline NDF-MPPI.

    The temperature follows the costs; everything else is the paper's.
    """
    return SubgoalTracker(GoalSource(), FieldSpace.shipped(env_id), preset("adaptive"))
