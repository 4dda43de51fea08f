"""3D Diffusion Policy (Ze et al., RSS 2024): point clouds of object, goal and scene."""

from __future__ import annotations

from icd_agent.policy.agent import ChunkAgent
from icd_agent.policy.policy import load_policy
from icd_agent.weights import DP3, shipped_folder


def make_dp3(env_id: str) -> ChunkAgent:
    """Build it with the weights of the package."""
    return ChunkAgent(load_policy(shipped_folder(env_id, DP3)))
