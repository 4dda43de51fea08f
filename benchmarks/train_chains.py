"""Autoencoder and denoiser of described states, for ICD and the baselines that share them."""

from __future__ import annotations

from pathlib import Path

from benchmarks.console import Values
from benchmarks.described import Described
from benchmarks.training_order import TrainingOrder
from benchmarks.training_progress import training
from icd_agent.checkpoints import weights_sha256
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.train import KIND as DIFFUSION
from icd_agent.diffusion.train import train_diffusion
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent, train_latent
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Trained


def fit_latent(
    described: Described,
    order: TrainingOrder,
    *,
    decoder_width: int = LatentConfig.decoder_width,
) -> Trained:
    """Train an autoencoder of described states, showing progress.

    Args:
        described: the states.
        order: how long, and where to.
        decoder_width: see ``LatentConfig``.
    """
    states, about = described
    points, features = states.features.shape[1:]
    scene_features = states.tokens.features.shape[-1]
    config = LatentConfig(features, scene_features, points, decoder_width=decoder_width)
    settings = TrainingConfig(steps=order.steps, learning_rate=1e-3, seed=order.seed)
    with training(f"latents of {order.env_id}", order.steps) as seen:
        return train_latent(
            states, config, settings, order.out, about=about, device=order.device, seen=seen
        )


def fit_diffusion(
    described: Described,
    order: TrainingOrder,
    latent: Path,
    *,
    places: int = DiffusionConfig.places,
    width: int = DiffusionConfig.width,
) -> Trained:
    """Train a denoiser of chains of described states, showing progress.

    Args:
        described: the states.
        order: how long, and where to.
        latent: folder of the autoencoder whose latents it is to meet.
        places: see ``DiffusionConfig``.
        width: see ``DiffusionConfig``.
    """
    states, about = described
    network = load_latent(latent)
    tokens, scene_features = states.tokens.features.shape[1:]
    config = DiffusionConfig(
        network.config.latent,
        scene_features,
        network.config.points,
        tokens,
        places=places,
        width=width,
    )
    settings = TrainingConfig(steps=order.steps, learning_rate=1e-3, seed=order.seed)
    about = {**about, "latent": weights_sha256(latent)}
    with training(f"chains of {order.env_id}", order.steps) as seen:
        return train_diffusion(
            states,
            network,
            config,
            settings,
            order.out,
            about=about,
            device=order.device,
            seen=seen,
        )


def fit_chains(
    described: Described,
    order: TrainingOrder,
    *,
    latent_steps: int,
    places: int = DiffusionConfig.places,
    width: int = DiffusionConfig.width,
) -> Values:
    """Train an autoencoder, then a denoiser of its latents.

    Args:
        described: the states.
        order: of the denoiser; the folders ``latent`` and ``diffusion`` of its run hold the parts.
        latent_steps: optimiser steps of the autoencoder.
        places: see ``DiffusionConfig``.
        width: see ``DiffusionConfig``.

    Returns:
        Names and values for the user.
    """
    encoder = fit_latent(described, order.part(LATENT, latent_steps))
    denoiser = fit_diffusion(
        described, order.part(DIFFUSION), order.out / LATENT, places=places, width=width
    )
    terms = {f"latent_{name}": value for name, value in encoder.terms.items()}
    return {
        "out": str(order.out),
        "seed": described.about["seed"],
        "parameters": encoder.parameters + denoiser.parameters,
        **terms,
        **denoiser.terms,
    }
