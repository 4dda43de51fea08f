"""What ``icd-bench train subgoal-diffuser`` does."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from benchmarks.console import Values
from benchmarks.described import describe_places
from benchmarks.parts import keep_beside
from benchmarks.train_chains import fit_chains
from benchmarks.training_order import TrainingOrder
from icd_agent.training.device import check_device

WIDTH: Final = 176
"""Of the denoiser; ICD's is 192. Both parts together are then below 8 MB."""


def train(order: TrainingOrder, *, field: Path | None, latent_steps: int) -> Values:
    """Train the autoencoder of object clouds, then the denoiser of chains of them.

    Args:
        order: of the denoiser; the folders ``latent`` and ``diffusion`` of its run hold the parts.
        field: folder of the field, which describes scenes; None is the package's. One that is given
            is copied beside the parts.
        latent_steps: optimiser steps of the autoencoder.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data, unusable device, see also ``train_latent``.
    """
    check_device(order.device)
    described = describe_places(order.env_id, order.data, field, order.episodes, order.split)
    values = fit_chains(described, order, latent_steps=latent_steps, places=0, width=WIDTH)
    keep_beside(field, order.out)
    return values
