"""How many control steps lie between two states: a distribution, and its soft minimum."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from icd_agent.latent.config import LatentConfig
from icd_agent.scene_tokens import SURFACE


class Reachability(nn.Module):
    """phi(r | z_1, z_2, E_s(P_s)) of the paper: a classifier over bins of steps."""

    def __init__(self, config: LatentConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.config = config
        width = 4 * config.width
        self.scene = nn.Sequential(
            nn.Linear(config.scene_features + 3, width // 2),
            nn.SiLU(),
            nn.Linear(width // 2, width // 2),
        )
        self.head = nn.Sequential(
            nn.Linear(3 * config.latent + width // 2, width),
            nn.SiLU(),
            nn.Linear(width, width),
            nn.SiLU(),
            nn.Linear(width, config.bins),
        )

    def forward(self, first: Tensor, second: Tensor, scene: Tensor) -> Tensor:
        """Logits (B, K).

        Args:
            first: (B, Z) latents of the earlier states.
            second: (B, Z) of the later ones.
            scene: (B, A, F + 3) scene tokens in the frame of the earlier states; those on surfaces
                are read.
        """
        around = self.scene(scene[:, :SURFACE]).amax(dim=1)
        inputs = torch.cat([first, second, second - first, around], dim=-1)
        logits: Tensor = self.head(inputs)
        return logits


def bins_of(steps: Tensor, config: LatentConfig) -> Tensor:
    """Index (…) of the bin that holds so many control steps (…)."""
    return (steps // config.bin_steps).clamp(max=config.bins - 1).long()


def expected_steps(logits: Tensor, config: LatentConfig) -> Tensor:
    """Mean of the distribution (B, K), in control steps (B,)."""
    return (logits.softmax(dim=-1) * _middles(logits, config)).sum(dim=-1)


def shortest_steps(logits: Tensor, config: LatentConfig) -> Tensor:
    """Soft minimum -s log E exp(-r / s) of the distribution (B, K), in control steps (B,).

    Data hold detours, so that the mean overestimates how far apart states are.
    """
    scaled = functional.log_softmax(logits, dim=-1) - _middles(logits, config) / config.softness
    return -config.softness * torch.logsumexp(scaled, dim=-1)


def _middles(like: Tensor, config: LatentConfig) -> Tensor:
    return (torch.arange(config.bins, device=like.device) + 0.5) * config.bin_steps
