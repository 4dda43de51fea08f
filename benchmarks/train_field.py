"""What ``icd-bench train field`` does."""

from __future__ import annotations

from pathlib import Path
from typing import Final, Literal

from benchmarks.console import Values
from benchmarks.training_progress import training
from icd_agent.field.config import FieldConfig
from icd_agent.field.data import FieldData
from icd_agent.field.train import train_field
from icd_agent.training.config import TrainingConfig
from icd_agent.training.device import check_device
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError

GLOBAL_CHANNELS: Final = 48
"""One code must hold what many anchors hold otherwise."""


def field_config(
    scope: Literal["local", "global"], *, length_scale: float, outlook_scale: float
) -> FieldConfig:
    """Sizes of a field; see ``FieldConfig``."""
    channels = FieldConfig.channels if scope == "local" else GLOBAL_CHANNELS
    return FieldConfig(
        scope, channels=channels, length_scale=length_scale, outlook_scale=outlook_scale
    )


def train(
    env_id: str,
    folder: Path,
    out: Path,
    config: FieldConfig,
    *,
    device: str,
    steps: int,
    scenes: int,
    seed: int,
) -> Values:
    """Read demonstrations, train, save.

    Args:
        env_id: what the demonstrations must be of.
        folder: of the demonstrations.
        out: of the run.
        config: sizes of the network.
        device: where to train.
        steps: optimiser steps in all.
        scenes: episodes whose scenes are used, at most.
        seed: of initial weights and data.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: demonstrations of another task, unusable device, see also ``train_field``.
    """
    check_device(device)
    demonstrations = Demonstrations(folder)
    header = demonstrations.header
    if header.env_id != env_id:
        raise DemonstrationsError(f"{folder} holds demonstrations of {header.env_id}, not {env_id}")
    data = FieldData.from_demonstrations(demonstrations, scenes)
    about = {"env": env_id, "options": dict(header.options), "seed": header.seed}
    settings = TrainingConfig(steps=steps, learning_rate=2e-3, seed=seed)
    with training(f"field of {env_id}", steps) as seen:
        trained = train_field(data, config, settings, out, about=about, device=device, seen=seen)
    parameters = sum(value.numel() for value in trained.model.parameters())
    return {"out": str(out), "scenes": len(data), "parameters": parameters, **trained.terms}
