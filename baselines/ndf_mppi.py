"""NDF-MPPI: the goal as the only subgoal, distances in descriptors."""

from __future__ import annotations

from pathlib import Path

from icd_agent.chain import GoalSource, WithPlaces
from icd_agent.field.space import FieldSpace
from icd_agent.field.train import load_field
from icd_agent.mppi.presets import ADAPTIVE
from icd_agent.presets import PRESETS, best_preset
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import LOCAL_FIELD, shipped_folder


def make_ndf_mppi(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build the paper's baseline NDF-MPPI.

    The temperature follows the costs, without control costs; everything else is the paper's.
    """
    return SubgoalTracker(GoalSource(), _space(env_id, weights), ADAPTIVE)


def make_ndf_mppi_improved(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build it with ICD's planner and cost, places included: what it lacks then is the chain."""
    settings = PRESETS[best_preset(env_id)]
    space = WithPlaces(_space(env_id, weights), settings.places)
    return SubgoalTracker(GoalSource(), space, settings.mppi)


def _space(env_id: str, weights: Path | None) -> FieldSpace:
    return FieldSpace(load_field(weights or shipped_folder(env_id, LOCAL_FIELD)))
