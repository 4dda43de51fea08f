"""What ``icd-bench train global-ndf`` does."""

from __future__ import annotations

from pathlib import Path

from benchmarks import train_field
from benchmarks.console import Values
from benchmarks.described import describe
from benchmarks.train_chains import fit_chains
from icd_agent.field.train import KIND as FIELD
from icd_agent.training.device import check_device


def train(
    env_id: str,
    data: Path,
    out: Path,
    *,
    device: str,
    field_steps: int | None,
    latent_steps: int,
    steps: int,
    episodes: int,
    seed: int,
) -> Values:
    """Train a field with one code a scene, then ICD's autoencoder and denoiser on it.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        out: of the run; its folders ``field``, ``latent`` and ``diffusion`` hold the parts.
        device: where to train.
        field_steps: optimiser steps of the field; None is as for the package's weights.
        latent_steps: of the autoencoder.
        steps: of the denoiser.
        episodes: how many are used, at most.
        seed: of initial weights and data.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data, unusable device, see also ``train_field`` and ``train_latent``.
    """
    check_device(device)
    scales = train_field.scales_of(env_id, "global")
    if field_steps is not None:
        scales = scales._replace(steps=field_steps)
    field = train_field.train(
        env_id,
        data,
        out / FIELD,
        "global",
        scales,
        device=device,
        scenes=min(episodes, train_field.SCENES),
        seed=seed,
    )
    described = describe(env_id, data, out / FIELD, episodes)
    chains = fit_chains(
        described, out, latent_steps=latent_steps, steps=steps, seed=seed, device=device
    )
    return {**{f"field_{name}": field[name] for name in ("loss", "iou", "cosine")}, **chains}
