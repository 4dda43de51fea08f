"""What ``icd-bench diagnose latent`` does: the autoencoder on states it has never seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from scipy.stats import spearmanr

from benchmarks.console import Values
from benchmarks.held_out import held_out
from benchmarks.parts import chain_parts
from icd_agent.diffusion.train import encode_states
from icd_agent.latent.model import LatentModel
from icd_agent.latent.pairs import draw_pairs
from icd_agent.latent.reachability import expected_steps, shortest_steps
from icd_agent.latent.train import load_latent
from icd_agent.states import States
from icd_envs.api import Float64Array

PAIRS = 4000
"""Pairs of states that steps are predicted between."""
NEAR = 60
"""[control steps] up to which the error is judged: subgoals are closer than this."""


def diagnose(
    env_id: str, scenes: int, *, seed: int, field: Path | None, weights: Path | None
) -> Values:
    """Measure an autoencoder on the noisy expert's states in test scenes.

    Args:
        env_id: which environment.
        scenes: how many.
        seed: of scenes and pairs.
        field: folder of the field; None is the package's.
        weights: folder of the autoencoder; None is the package's.

    Returns:
        ``reconstruction_error``, a share of the variance of the descriptors; ``bins_off``, median
        error of the expected steps of pairs up to 60 steps apart, in bins; ``rank_correlation``
        (Spearman) of expected and true steps of all pairs, and ``rank_correlation_solved`` of those
        in episodes that solve their task: the others end stuck, and nothing tells how long;
        ``shortest_over_true``, mean ratio of the soft minimum to the true steps.

    Raises:
        IcdError: unknown environment, missing or damaged weights.
    """
    parts = chain_parts(env_id, field, weights)
    model = load_latent(parts.latent)
    states = held_out(env_id, scenes, seed=seed, field=parts.field).states
    latents = encode_states(states, model)
    return {
        "scenes": len(states.success),
        "states": len(states.step),
        "reconstruction_error": _reconstruction(model, states, latents),
        **_reachability(model, states, latents, np.random.default_rng([seed])),
    }


def _reconstruction(model: LatentModel, states: States, latents: torch.Tensor) -> float:
    features = states.features.astype(np.float32)
    canonical = torch.from_numpy(states.canonical)
    with torch.no_grad():
        found = [model.decode(part, canonical).numpy() for part in torch.split(latents, 256)]
    error = np.square(np.concatenate(found) - features).sum(-1).mean()
    variance = np.square(features - features.mean(axis=(0, 1))).sum(-1).mean()
    return float(error / variance)


def _reachability(
    model: LatentModel, states: States, latents: torch.Tensor, rng: np.random.Generator
) -> Values:
    pairs = draw_pairs(states, PAIRS, rng)
    config = model.config
    scene = torch.from_numpy(states.seen_from(pairs.first, config.scene_size))
    with torch.no_grad():
        logits = model.reachability(
            latents[torch.from_numpy(pairs.first)], latents[torch.from_numpy(pairs.second)], scene
        )
    expected: Float64Array = expected_steps(logits, config).double().numpy()
    shortest: Float64Array = shortest_steps(logits, config).double().numpy()
    near, apart = pairs.gap <= NEAR, pairs.gap > 0
    solved = states.success[states.episode[pairs.first]]
    return {
        "bins_off": float(np.median(np.abs(expected - pairs.gap)[near]) / config.bin_steps),
        "rank_correlation": float(spearmanr(expected, pairs.gap).statistic),
        "rank_correlation_solved": float(spearmanr(expected[solved], pairs.gap[solved]).statistic)
        if solved.any()
        else None,
        "shortest_over_true": float(np.mean(shortest[apart] / pairs.gap[apart])),
    }
