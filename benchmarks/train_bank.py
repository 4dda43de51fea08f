"""What ``icd-bench train bank`` does."""

from __future__ import annotations

from pathlib import Path

from benchmarks.console import Values
from benchmarks.described import describe
from benchmarks.parts import chain_parts
from icd_agent.checkpoints import save_checkpoint, weights_sha256
from icd_agent.diffusion.retrieval import KIND, make_bank
from icd_agent.diffusion.train import encode_states
from icd_agent.latent.train import load_latent

CHAINS = 300


def bank(
    env_id: str,
    data: Path,
    out: Path,
    *,
    field: Path | None,
    latent: Path | None,
    episodes: int,
) -> Values:
    """Describe and encode recorded states, keep chains of them.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        out: where the bank is saved.
        field: folder of the field; None is the package's.
        latent: folder of the autoencoder; None is the package's.
        episodes: how many are looked at, at most.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data or weights, or no episode that solved its task.
    """
    parts = chain_parts(env_id, field, latent)
    network = load_latent(parts.latent)
    states, about = describe(env_id, data, parts.field, episodes, "train")
    kept = make_bank(states, encode_states(states, network), CHAINS)
    about = {**about, "latent": weights_sha256(parts.latent), "episodes": len(states.success)}
    save_checkpoint(out, KIND, kept, kept.config, {"data": about})
    return {"out": str(out), "chains": kept.config.chains}
