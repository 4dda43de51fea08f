"""Autoencoder and denoiser of described states, for ICD and the baselines that share them."""

from __future__ import annotations

from pathlib import Path

from benchmarks.console import Values
from benchmarks.described import Described
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


def fit_latent(described: Described, out: Path, *, steps: int, seed: int, device: str) -> Trained:
    """Train an autoencoder of described states, showing progress.

    Args:
        described: the states.
        out: of the run.
        steps: optimiser steps in all.
        seed: of initial weights and data.
        device: where to train.
    """
    states, about = described
    points, features = states.features.shape[1:]
    config = LatentConfig(features, states.tokens.features.shape[-1], points)
    settings = TrainingConfig(steps=steps, learning_rate=1e-3, seed=seed)
    with training(f"latents of {about['env']}", steps) as seen:
        return train_latent(states, config, settings, out, about=about, device=device, seen=seen)


def fit_diffusion(
    described: Described,
    latent: Path,
    out: Path,
    *,
    steps: int,
    seed: int,
    device: str,
    places: int = DiffusionConfig.places,
    width: int = DiffusionConfig.width,
) -> Trained:
    """Train a denoiser of chains of described states, showing progress.

    Args:
        described: the states.
        latent: folder of the autoencoder whose latents it is to meet.
        out: of the run.
        steps: optimiser steps in all.
        seed: of initial weights and data.
        device: where to train.
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
    settings = TrainingConfig(steps=steps, learning_rate=1e-3, seed=seed)
    about = {**about, "latent": weights_sha256(latent)}
    with training(f"chains of {about['env']}", steps) as seen:
        return train_diffusion(
            states,
            network,
            config,
            settings,
            out,
            about=about,
            device=device,
            seen=seen,
        )


def fit_chains(
    described: Described,
    out: Path,
    *,
    latent_steps: int,
    steps: int,
    seed: int,
    device: str,
    places: int = DiffusionConfig.places,
    width: int = DiffusionConfig.width,
) -> Values:
    """Train an autoencoder, then a denoiser of its latents.

    Args:
        described: the states.
        out: of the run; its folders ``latent`` and ``diffusion`` hold the parts.
        latent_steps: optimiser steps of the autoencoder.
        steps: of the denoiser.
        seed: of initial weights and data.
        device: where to train.
        places: see ``DiffusionConfig``.
        width: see ``DiffusionConfig``.

    Returns:
        Names and values for the user.
    """
    encoder = fit_latent(described, out / LATENT, steps=latent_steps, seed=seed, device=device)
    denoiser = fit_diffusion(
        described,
        out / LATENT,
        out / DIFFUSION,
        steps=steps,
        seed=seed,
        device=device,
        places=places,
        width=width,
    )
    parameters = sum(x.numel() for part in (encoder, denoiser) for x in part.model.parameters())
    terms = {f"latent_{name}": value for name, value in encoder.terms.items()}
    return {
        "out": str(out),
        "seed": described.about["seed"],
        "parameters": parameters,
        **terms,
        **denoiser.terms,
    }
