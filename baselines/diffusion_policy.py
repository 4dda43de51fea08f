"""Diffusion Policy (Chi et al., RSS 2023), goal-conditioned, on key points.

As the paper adapts it (section V-B): object and goal as key points; the scene by what the field
describes, where the paper takes features of the field's encoder.
"""

from __future__ import annotations

from pathlib import Path

from icd_agent.policy.agent import ChunkAgent
from icd_agent.weights import DIFFUSION_POLICY, shipped_folder


def make_diffusion_policy(env_id: str, weights: Path | None = None) -> ChunkAgent:
    """Build it, with the field beside its weights, or else the package's.

    Args:
        env_id: whose weights of the package.
        weights: see ``ChunkAgent.from_pretrained``; None is the package's.

    Raises:
        CheckpointError: missing or damaged weights, or those of another task.
    """
    return ChunkAgent.from_pretrained(weights or shipped_folder(env_id, DIFFUSION_POLICY), env_id)
