"""Global NDF: as NDF-MPPI, but one code describes the whole scene, as in the first NDF.

The paper's row adds generated subgoals; until they are trained for it, the goal is the only one.
"""

from __future__ import annotations

from pathlib import Path

from icd_agent.chain import GoalSource
from icd_agent.field.space import FieldSpace
from icd_agent.field.train import load_field
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import GLOBAL_FIELD, shipped_folder


def make_global_ndf(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build the paper's baseline Global NDF, as far as it goes with the goal alone."""
    space = FieldSpace(load_field(weights or shipped_folder(env_id, GLOBAL_FIELD)))
    return SubgoalTracker(GoalSource(), space, preset("adaptive"))
