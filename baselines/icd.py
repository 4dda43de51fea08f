"""ICD with the weights of the package, as it does best and as the paper describes it."""

from __future__ import annotations

from icd_agent.agent import ICDAgent, best_preset, load_networks
from icd_agent.weights import shipped_folder


def make_icd(env_id: str) -> ICDAgent:
    """Build Implicit Contact Diffuser as it does best."""
    return ICDAgent(load_networks(shipped_folder(env_id)), best_preset(env_id))


def make_icd_paper(env_id: str) -> ICDAgent:
    """Build it as the paper describes it: one chain, the goal in-painted, white noise."""
    return ICDAgent(load_networks(shipped_folder(env_id)), "paper")
