"""What ``icd-bench train latent`` and ``train diffusion`` do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.console import Values
from benchmarks.described import Described, describe
from benchmarks.training_progress import training
from icd_agent.checkpoints import weights_sha256
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.train import train_diffusion
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent, train_latent
from icd_agent.training.config import TrainingConfig
from icd_agent.training.device import check_device
from icd_agent.training.loop import Trained
from icd_agent.weights import shipped_folder


def latent(
    env_id: str,
    data: Path,
    out: Path,
    *,
    field: Path | None,
    device: str,
    steps: int,
    episodes: int,
    seed: int,
) -> Values:
    """Describe recorded states, train the autoencoder on them, save.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        out: of the run.
        field: folder of the field; None is the package's.
        device: where to train.
        steps: optimiser steps in all.
        episodes: how many are used, at most.
        seed: of initial weights and data.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data or weights, unusable device, see also ``train_latent``.
    """
    check_device(device)
    described = describe(env_id, data, field, episodes)
    trained = fit_latent(described, out, steps=steps, seed=seed, device=device)
    return _values(out, trained, described.about)


def diffusion(
    env_id: str,
    data: Path,
    out: Path,
    *,
    field: Path | None,
    latent: Path | None,
    device: str,
    steps: int,
    episodes: int,
    seed: int,
) -> Values:
    """Describe and encode recorded states, train the denoiser on chains of them, save.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        out: of the run.
        field: folder of the field; None is the package's.
        latent: folder of the autoencoder; None is the package's.
        device: where to train.
        steps: optimiser steps in all.
        episodes: how many are used, at most.
        seed: of initial weights and data.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data or weights, unusable device, see also ``train_diffusion``.
    """
    check_device(device)
    folder = shipped_folder(env_id, LATENT) if latent is None else latent
    described = describe(env_id, data, field, episodes)
    trained = fit_diffusion(described, folder, out, steps=steps, seed=seed, device=device)
    return _values(out, trained, described.about)


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
    half: bool = False,
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
        half: save the weights in half precision.
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
            half=half,
            seen=seen,
        )


def _values(out: Path, trained: Trained, about: dict[str, Any]) -> Values:
    parameters = sum(value.numel() for value in trained.model.parameters())
    return {"out": str(out), "seed": about["seed"], "parameters": parameters, **trained.terms}
