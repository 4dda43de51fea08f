"""What ``icd-bench train latent`` and ``train diffusion`` do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.console import Values
from benchmarks.described import describe
from benchmarks.train_chains import fit_diffusion, fit_latent
from icd_agent.latent.train import KIND as LATENT
from icd_agent.training.device import check_device
from icd_agent.training.loop import Trained
from icd_agent.weights import shipped_chains


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
    folder = shipped_chains(env_id, LATENT) if latent is None else latent
    described = describe(env_id, data, field, episodes)
    trained = fit_diffusion(described, folder, out, steps=steps, seed=seed, device=device)
    return _values(out, trained, described.about)


def _values(out: Path, trained: Trained, about: dict[str, Any]) -> Values:
    parameters = sum(value.numel() for value in trained.model.parameters())
    return {"out": str(out), "seed": about["seed"], "parameters": parameters, **trained.terms}
