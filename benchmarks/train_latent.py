"""What ``icd-bench train latent`` and ``train diffusion`` do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.console import Values
from benchmarks.described import describe
from benchmarks.parts import chain_parts
from benchmarks.train_chains import fit_diffusion, fit_latent
from benchmarks.training_order import TrainingOrder
from icd_agent.training.device import check_device
from icd_agent.training.loop import Trained


def latent(order: TrainingOrder, *, field: Path | None, decoder_width: int) -> Values:
    """Describe recorded states, train the autoencoder on them, save.

    Args:
        order: what to train on, and where to.
        field: folder of the field; None is the package's.
        decoder_width: see ``LatentConfig``.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data or weights, unusable device, see also ``train_latent``.
    """
    check_device(order.device)
    described = describe(order.env_id, order.data, field, order.episodes, order.split)
    trained = fit_latent(described, order, decoder_width=decoder_width)
    return _values(order, trained, described.about)


def diffusion(
    order: TrainingOrder, *, field: Path | None, latent: Path | None, places: int
) -> Values:
    """Describe and encode recorded states, train the denoiser on chains of them, save.

    Args:
        order: what to train on, and where to.
        field: folder of the field; None is the package's.
        latent: folder of the autoencoder; None is the package's.
        places: see ``DiffusionConfig``.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data or weights, unusable device, see also ``train_diffusion``.
    """
    check_device(order.device)
    parts = chain_parts(order.env_id, field, latent)
    described = describe(order.env_id, order.data, parts.field, order.episodes, order.split)
    trained = fit_diffusion(described, order, parts.latent, places=places)
    return _values(order, trained, described.about)


def _values(order: TrainingOrder, trained: Trained, about: dict[str, Any]) -> Values:
    return {
        "out": str(order.out),
        "seed": about["seed"],
        "parameters": trained.parameters,
        **trained.terms,
    }
