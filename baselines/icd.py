"""ICD as it does best, on the local field alone and with the paper's settings."""

from __future__ import annotations

from pathlib import Path

from icd_agent.agent import ICDAgent
from icd_agent.networks import load_networks, load_shipped, one_field
from icd_agent.presets import best_preset
from icd_agent.weights import LOCAL, shipped_folder


def make_icd(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build Implicit Contact Diffuser as it does best."""
    networks = load_networks(weights, env_id) if weights else load_shipped(env_id)
    return ICDAgent(networks, best_preset(networks.env_id or env_id))


def make_icd_local(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it with one field, the local one, in which chains are generated and followed.

    Raises:
        CheckpointError: missing or damaged weights, or those of other fields.
    """
    networks = one_field(load_networks(weights or shipped_folder(env_id, LOCAL), env_id), "local")
    return ICDAgent(networks, best_preset(networks.env_id or env_id))


def make_icd_paper(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it with the paper's settings: besides, one chain, decoded, the goal in-painted.

    The networks are ``icd-local``'s; what in them is not the paper's is told in docs/method.md.

    Raises:
        CheckpointError: missing or damaged weights, or those of other fields.
    """
    networks = one_field(load_networks(weights or shipped_folder(env_id, LOCAL), env_id), "local")
    return ICDAgent(networks, "paper")
