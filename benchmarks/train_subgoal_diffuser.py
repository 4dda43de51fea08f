"""What ``icd-bench train subgoal-diffuser`` does."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from benchmarks.console import Values
from benchmarks.described import describe_places
from benchmarks.training_progress import training
from icd_agent.checkpoints import weights_sha256
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.train import KIND as DIFFUSION
from icd_agent.diffusion.train import train_diffusion
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent, train_latent
from icd_agent.training.config import TrainingConfig
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
    states, about = describe_places(env_id, data, None, episodes)
    points, features = states.features.shape[1:]
    tokens, scene_features = states.tokens.features.shape[1:]
    sizes = LatentConfig(features, scene_features, points)
    settings = TrainingConfig(steps=latent_steps, learning_rate=1e-3, seed=seed)
    with training(f"latents of {env_id}", latent_steps) as seen:
        encoder = train_latent(
            states, sizes, settings, out / LATENT, about=about, device=device, seen=seen
        )
    # Read back, so that the denoiser is trained on the latents that it will meet.
    network = load_latent(out / LATENT)
    config = DiffusionConfig(
        network.config.latent, scene_features, points, tokens, places=0, width=WIDTH
    )
    settings = TrainingConfig(steps=steps, learning_rate=1e-3, seed=seed)
    about = {**about, "latent": weights_sha256(out / LATENT)}
    with training(f"chains of {env_id}", steps) as seen:
        denoiser = train_diffusion(
            states,
            network,
            config,
            settings,
            out / DIFFUSION,
            about=about,
            device=device,
            half=True,
            seen=seen,
        )
    parameters = sum(x.numel() for part in (encoder, denoiser) for x in part.model.parameters())
    terms = {f"latent_{name}": value for name, value in encoder.terms.items()}
    return {
        "out": str(out),
        "seed": about["seed"],
        "parameters": parameters,
        **terms,
        **denoiser.terms,
    }
