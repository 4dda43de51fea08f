"""What ``icd-bench train subgoal-diffuser`` does."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from benchmarks.console import Values
from benchmarks.described import describe_places
from benchmarks.train_chains import fit_chains
from icd_agent.training.device import check_device

WIDTH: Final = 176
"""Of the denoiser; ICD's is 192. Both parts together are then below 8 MB."""


def train(
    env_id: str,
    data: Path,
    out: Path,
    *,
    device: str,
    latent_steps: int,
    steps: int,
    episodes: int,
    seed: int,
) -> Values:
    """Train the autoencoder of object clouds, then the denoiser of chains of them.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        out: of the run; its folders ``latent`` and ``diffusion`` hold the parts.
        device: where to train.
        latent_steps: optimiser steps of the autoencoder.
        steps: of the denoiser.
        episodes: how many are used, at most.
        seed: of initial weights and data.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data, unusable device, see also ``train_latent``.
    """
    check_device(device)
    described = describe_places(env_id, data, None, episodes)
    return fit_chains(
        described,
        out,
        latent_steps=latent_steps,
        steps=steps,
        seed=seed,
        device=device,
        places=0,
        width=WIDTH,
    )
