"""What ``icd-bench train field`` does."""

from __future__ import annotations

from pathlib import Path
from typing import Final, Literal, NamedTuple

from benchmarks.console import Values
from benchmarks.described import about_of, read_demonstrations
from benchmarks.training_progress import training
from icd_agent.field.config import FieldConfig
from icd_agent.field.data import FieldData
from icd_agent.field.supervision import NEAR_SPREAD
from icd_agent.field.train import train_field
from icd_agent.training.config import TrainingConfig
from icd_agent.training.device import check_device
from icd_agent.weights import weights_name
from icd_envs.tasks.problem import Split

SCENES: Final = 1500
"""Episodes whose scenes a field is trained on, at most."""
Scope = Literal["local", "global"]


class Scales(NamedTuple):
    """Sizes of what stands in a task's scenes, as the shipped weights were trained.

    Attributes:
        length: [m] ``FieldConfig.length_scale``.
        outlook: [m] ``FieldConfig.outlook_scale``.
        near: [m] ``near_spread`` of ``draw_queries``.
        anchors: ``FieldConfig.anchors``; a larger surface needs more.
        steps: optimiser steps.
    """

    length: float = FieldConfig.length_scale
    outlook: float = FieldConfig.outlook_scale
    near: float = NEAR_SPREAD
    anchors: int = FieldConfig.anchors
    steps: int = 3000


SCALES: Final = {"notebook-folding": Scales(0.5, 0.15, 0.05, 384, 4500)}
"""Of the tasks whose fixtures are larger than a clip."""


def scales_of(env_id: str, scope: Scope) -> Scales:
    """Those that the shipped weights of this environment were trained with, or the default."""
    scales = SCALES.get(weights_name(env_id) or "", Scales())
    if scope == "local":
        return scales
    steps = 4000 if weights_name(env_id) == "notebook-folding" else 6000
    return scales._replace(anchors=64, steps=steps)


def train(
    env_id: str,
    folder: Path,
    out: Path,
    scope: Scope,
    scales: Scales,
    *,
    device: str,
    scenes: int,
    seed: int,
    split: Split = "train",
) -> Values:
    """Read demonstrations, train, save.

    Args:
        env_id: what the demonstrations must be of.
        folder: of the demonstrations.
        out: of the run.
        scope: of the field, see ``FieldConfig``.
        scales: of the field.
        device: where to train.
        scenes: episodes whose scenes are used, at most.
        seed: of initial weights and data.
        split: the scenes that the demonstrations must be of.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: demonstrations of another task, unusable device, see also ``train_field``.
    """
    check_device(device)
    demonstrations = read_demonstrations(env_id, folder, split)
    about = about_of(demonstrations, scenes)
    config = FieldConfig(
        scope,
        scales.anchors,
        length_scale=scales.length,
        outlook_scale=scales.outlook,
    )
    data = FieldData.from_demonstrations(demonstrations, scenes, scales.near, config.floor_margin)
    settings = TrainingConfig(steps=scales.steps, learning_rate=2e-3, seed=seed)
    with training(f"field of {env_id}", scales.steps) as seen:
        trained = train_field(data, config, settings, out, about=about, device=device, seen=seen)
    return {"out": str(out), "scenes": len(data), "parameters": trained.parameters, **trained.terms}
