"""NDF-MPPI: the goal as the only subgoal, distances in descriptors."""

from __future__ import annotations

from pathlib import Path

from icd_agent.chain import GoalSource
from icd_agent.field.space import FieldSpace
from icd_agent.field.train import load_field
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import LOCAL_FIELD, shipped_folder


def make_ndf_mppi(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build the paper's baseline NDF-MPPI.

    The temperature follows the costs; everything else is the paper's.
    """
    space = FieldSpace(load_field(weights or shipped_folder(env_id, LOCAL_FIELD)))
    return SubgoalTracker(GoalSource(), space, preset("adaptive"))
