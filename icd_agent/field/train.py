"""Train a field from demonstrations."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from torch import Tensor, nn

from icd_agent.checkpoints import load_checkpoint
from icd_agent.field.config import FieldConfig
from icd_agent.field.data import FieldData
from icd_agent.field.field import SceneField
from icd_agent.field.losses import field_loss
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Seen, Trained
from icd_agent.training.network import Network, train_network

KIND: Final = "field"
BATCH_SCENES: Final = 8
BATCH_QUERIES: Final = 320
"""Queries per scene; each has a companion."""


def train_field(
    data: FieldData,
    config: FieldConfig,
    training: TrainingConfig,
    out: Path,
    *,
    about: dict[str, Any],
    device: str = "cpu",
    seen: Seen = lambda step, terms: None,
) -> Trained:
    """Train, or go on with a killed run, and save the weights in ``out``.

    Args:
        data: training scenes.
        config: sizes of the network.
        training: how to train.
        out: folder of the run's state, its log and in the end its checkpoint.
        about: where the data come from; part of the run's identity and of the checkpoint.
        device: where to train.
        seen: shows progress.

    Raises:
        TrainingError: see ``icd_agent.training.loop.train``.
    """

    def loss(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        clouds, truth, pairs = data.draw(BATCH_SCENES, BATCH_QUERIES, rng, device)
        return field_loss(model(clouds, truth.points), truth, pairs, config)

    about = {**about, "scenes": len(data), "near_spread": data.near_spread}
    network = Network(KIND, config, lambda: SceneField(config))
    return train_network(network, loss, training, out, about=about, device=device, seen=seen)


def load_field(folder: Path) -> SceneField:
    """Read a trained field.

    Raises:
        CheckpointError: see ``icd_agent.checkpoints.load_checkpoint``.
    """
    return load_checkpoint(folder, KIND, lambda given: SceneField(FieldConfig(**given)))
