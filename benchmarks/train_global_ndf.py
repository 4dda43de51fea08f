"""What ``icd-bench train global-ndf`` does."""

from __future__ import annotations

from benchmarks import train_field
from benchmarks.console import Values
from benchmarks.described import describe
from benchmarks.train_chains import fit_chains
from benchmarks.training_order import TrainingOrder
from icd_agent.field.train import KIND as FIELD
from icd_agent.training.device import check_device


def train(order: TrainingOrder, *, field_steps: int | None, latent_steps: int) -> Values:
    """Train a field with one code a scene, then ICD's autoencoder and denoiser on it.

    Args:
        order: of the denoiser; the folders ``field``, ``latent`` and ``diffusion`` of its run hold
            the parts.
        field_steps: optimiser steps of the field; None is as for the package's weights.
        latent_steps: of the autoencoder.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data, unusable device, see also ``train_field`` and ``train_latent``.
    """
    check_device(order.device)
    scales = train_field.scales_of(order.env_id, "global")
    if field_steps is not None:
        scales = scales._replace(steps=field_steps)
    field = train_field.train(
        order.env_id,
        order.data,
        order.out / FIELD,
        "global",
        scales,
        device=order.device,
        scenes=min(order.episodes, train_field.SCENES),
        seed=order.seed,
        split=order.split,
    )
    described = describe(order.env_id, order.data, order.out / FIELD, order.episodes, order.split)
    chains = fit_chains(described, order, latent_steps=latent_steps)
    return {**{f"field_{name}": field[name] for name in ("loss", "iou", "cosine")}, **chains}
