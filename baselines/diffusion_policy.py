"""Diffusion Policy (Chi et al., RSS 2023), goal-conditioned, on key points.

As the paper adapts it (section V-B): object and goal as key points, the scene as the encoder of
the descriptor field has it.
"""

from __future__ import annotations

from pathlib import Path

from icd_agent.field.train import load_field
from icd_agent.policy.agent import ChunkAgent
from icd_agent.policy.policy import load_policy
from icd_agent.weights import DIFFUSION_POLICY, LOCAL_FIELD, shipped_folder


def make_diffusion_policy(env_id: str, weights: Path | None = None) -> ChunkAgent:
    """Build it, with the package's field."""
    policy = load_policy(weights or shipped_folder(env_id, DIFFUSION_POLICY))
    return ChunkAgent(policy, load_field(shipped_folder(env_id, LOCAL_FIELD)))
