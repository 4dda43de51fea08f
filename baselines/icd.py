"""ICD as it does best and as the paper describes it, with the weights of the package or others."""

from __future__ import annotations

from pathlib import Path

from icd_agent.agent import ICDAgent, best_preset, load_networks
from icd_agent.weights import shipped_folder


def make_icd(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build Implicit Contact Diffuser as it does best."""
    return ICDAgent(load_networks(weights or shipped_folder(env_id)), best_preset(env_id))


def make_icd_paper(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it as the paper describes it: one chain, the goal in-painted, white noise."""
    return ICDAgent(load_networks(weights or shipped_folder(env_id)), "paper")
