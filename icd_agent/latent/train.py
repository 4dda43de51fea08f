"""Train the autoencoder and the reachability head together."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from icd_agent.checkpoints import load_checkpoint
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.latent.pairs import draw_pairs
from icd_agent.latent.principal import principal
from icd_agent.latent.reachability import bins_of, expected_steps
from icd_agent.states import States
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Seen, Trained
from icd_agent.training.network import Network, train_network

KIND: Final = "latent"
BATCH: Final = 32
"""Pairs of a batch."""
KL_WEIGHT: Final = 1e-6
REACH_WEIGHT: Final = 1e-3
"""The paper's is 1e-5; this one gives the latents some of it and changes nothing else, because
the head's own steps are those of Adam, which are the same for any weight."""
DECODED: Final = 50
"""Points of each state that are decoded in a step: the decoder takes them one by one, and a wider
decoder of fewer points learns more in the same time."""
STATISTICS: Final = 4000
"""States that principal components are taken from."""


def train_latent(
    states: States,
    config: LatentConfig,
    training: TrainingConfig,
    out: Path,
    *,
    about: dict[str, Any],
    device: str = "cpu",
    seen: Seen = lambda step, terms: None,
) -> Trained:
    """Train, or go on with a killed run, and save the weights in ``out`` in half precision.

    Args:
        states: of recorded episodes.
        config: sizes of the network.
        training: how to train.
        out: folder of the run's state, its log and in the end its checkpoint.
        about: where the data come from; part of the run's identity and of the checkpoint.
        device: where to train.
        seen: shows progress.

    Raises:
        TrainingError: see ``icd_agent.training.loop.train``.
    """
    rng = np.random.default_rng([training.seed])
    rows = states.draw(STATISTICS, rng)
    linear = principal(states.features[rows].astype(np.float32), config.latent)
    canonical = torch.from_numpy(states.canonical).to(device)

    def loss(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        assert isinstance(model, LatentModel)
        pairs = draw_pairs(states, BATCH, rng)
        rows = np.concatenate([pairs.first, pairs.second])
        features = torch.from_numpy(states.features[rows].astype(np.float32)).to(device)
        noise = rng.normal(size=(len(rows), config.latent)).astype(np.float32)
        tokens = states.seen_from(pairs.first, config.scene_size)
        decoded = rng.permutation(len(canonical))[:DECODED]
        return latent_loss(
            model,
            features,
            canonical,
            torch.from_numpy(tokens).to(device),
            torch.from_numpy(pairs.gap).to(device),
            torch.from_numpy(noise).to(device),
            torch.from_numpy(decoded).to(device),
        )

    about = {**about, "episodes": len(states.success), "states": len(states.step)}
    network = Network(KIND, config, lambda: LatentModel(config, linear), half=True)
    return train_network(network, loss, training, out, about=about, device=device, seen=seen)


def latent_loss(
    model: LatentModel,
    features: Tensor,
    canonical: Tensor,
    scene: Tensor,
    gap: Tensor,
    noise: Tensor,
    decoded: Tensor,
) -> dict[str, Tensor]:
    """Terms of the loss of one batch of pairs.

    Args:
        model: with the principal components of the features.
        features: (2 B, N, D) of the cost space, the earlier states first.
        canonical: (N, 3) [m].
        scene: (B, A, F + 3) tokens seen from the earlier states.
        gap: (B,) control steps.
        noise: (2 B, Z) standard normal.
        decoded: (P,) indices of the points that are decoded.
    """
    wanted = model.normalise(features)
    mean, log_variance = model.distribution(wanted, canonical)
    latents = mean + noise * (0.5 * log_variance).exp()
    # Normalised features have a variance of 1 / D: per dimension, the error is a share of it.
    error = model.reconstruct(latents, canonical, decoded) - wanted[:, decoded]
    recon = error.square().sum(-1).mean()
    kl = 0.5 * (mean.square() + log_variance.exp() - 1.0 - log_variance).sum(-1).mean()
    first, second = latents.chunk(2)
    logits = model.reachability(first, second, scene)
    reach = functional.cross_entropy(logits, bins_of(gap, model.config))
    off = (expected_steps(logits, model.config) - gap).abs().mean()
    return {
        "loss": recon + KL_WEIGHT * kl + REACH_WEIGHT * reach,
        "recon": recon,
        "kl": kl,
        "reach": reach,
        "steps_off": off,
    }


def load_latent(folder: Path) -> LatentModel:
    """Read a trained autoencoder.

    Raises:
        CheckpointError: see ``icd_agent.checkpoints.load_checkpoint``.
    """
    return load_checkpoint(folder, KIND, lambda given: LatentModel(LatentConfig(**given)))
