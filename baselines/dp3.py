"""3D Diffusion Policy (Ze et al., RSS 2024): point clouds of object, goal and scene."""

from __future__ import annotations

from pathlib import Path

from icd_agent.policy.agent import ChunkAgent
from icd_agent.weights import DP3, shipped_folder


def make_dp3(env_id: str, weights: Path | None = None) -> ChunkAgent:
    """Build it.

    Args:
        env_id: whose weights of the package.
        weights: see ``ChunkAgent.from_pretrained``; None is the package's.

    Raises:
        CheckpointError: missing or damaged weights, or those of another task.
    """
    return ChunkAgent.from_pretrained(weights or shipped_folder(env_id, DP3), env_id)
