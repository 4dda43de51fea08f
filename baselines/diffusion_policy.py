"""Diffusion Policy (Chi et al., RSS 2023), goal-conditioned, on key points.

As the paper adapts it (section V-B): object and goal as key points, the scene as the encoder of
the descriptor field has it.
"""

from __future__ import annotations

from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.policy.agent import ChunkAgent
from icd_agent.policy.policy import load_policy
from icd_agent.weights import DIFFUSION_POLICY, shipped_folder


def make_diffusion_policy(env_id: str) -> ChunkAgent:
    """Build it with the weights of the package."""
    field = load_field(shipped_folder(env_id, FIELD))
    return ChunkAgent(load_policy(shipped_folder(env_id, DIFFUSION_POLICY)), field)
