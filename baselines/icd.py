"""ICD as it does best, on the local field alone and as the paper describes it."""

from __future__ import annotations

from pathlib import Path

from icd_agent.agent import ICDAgent
from icd_agent.networks import load_networks, load_shipped
from icd_agent.presets import best_preset
from icd_agent.weights import LOCAL, shipped_folder


def make_icd(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build Implicit Contact Diffuser as it does best."""
    networks = load_networks(weights, env_id) if weights else load_shipped(env_id)
    return ICDAgent(networks, best_preset(networks.env_id or env_id))


def make_icd_local(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it with one field, the local one, in which chains are generated and followed."""
    networks = load_networks(weights or shipped_folder(env_id, LOCAL), env_id)
    return ICDAgent(networks, best_preset(networks.env_id or env_id))


def make_icd_paper(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it as the paper describes it: besides, one chain, the goal in-painted, white noise."""
    networks = load_networks(weights or shipped_folder(env_id, LOCAL), env_id)
    return ICDAgent(networks, "paper")
