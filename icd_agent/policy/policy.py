"""A policy: what is seen -> a chunk of actions, by diffusion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.checkpoints import load_checkpoint
from icd_agent.diffusion.schedule import make_schedule
from icd_agent.policy.config import PolicyConfig
from icd_agent.policy.encoders import KeyPointEncoder, PointEncoder, Seen
from icd_agent.policy.unet import ConditionalUNet

if TYPE_CHECKING:
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler

    from icd_envs.api import Float32Array

KIND: Final = "policy"
ACTION: Final = 3
"""Numbers per action."""


class ChunkPolicy(nn.Module):
    """Encoder and U-Net; places enter between -1 and 1, as actions are."""

    low: Tensor
    high: Tensor

    def __init__(self, config: PolicyConfig, limits: tuple[Tensor, Tensor] | None = None) -> None:
        """Build the layers.

        Args:
            config: sizes.
            limits: (3,) [m] smallest and largest places in the data; None while weights are loaded.
        """
        super().__init__()
        self.config = config
        encoder = KeyPointEncoder if config.sees == "key points" else PointEncoder
        self.encoder = encoder(config)
        self.unet = ConditionalUNet(config, ACTION, self.encoder.size)
        low, high = (-torch.ones(3), torch.ones(3)) if limits is None else limits
        self.register_buffer("low", low)
        self.register_buffer("high", high)

    def condition(self, seen: Seen) -> Tensor:
        """(B, C) of what is seen [m]."""
        return self.encoder(Seen(*(self._normalise(part) for part in seen)))

    def forward(self, noisy: Tensor, time: Tensor, condition: Tensor) -> Tensor:
        """The prediction (B, H, 3); see ``ConditionalUNet.forward``."""
        predicted: Tensor = self.unet(noisy, time, condition)
        return predicted

    def schedule(self) -> DDIMScheduler:
        """Of the noise; see ``schedule_of``."""
        return schedule_of(self.config)

    @torch.no_grad()
    def sample(self, seen: Seen, rng: np.random.Generator) -> Float32Array:
        """Actions (B, H, 3) in [-1, 1].

        Args:
            seen: [m].
            rng: source of every draw.
        """
        condition, schedule = self.condition(seen), self.schedule()
        schedule.set_timesteps(self.config.denoising_steps)
        shape = len(condition), self.config.horizon, ACTION

        def noise() -> Tensor:
            return torch.from_numpy(rng.normal(size=shape).astype(np.float32))

        values = self.config.temperature * noise()
        for time in schedule.timesteps:
            predicted = self(values, time.expand(len(values)), condition)
            values = schedule.step(
                predicted,
                time,
                values,
                eta=self.config.eta,
                variance_noise=noise(),
                return_dict=False,
            )[0]
        return values.clamp(-1.0, 1.0).numpy()

    def _normalise(self, values: Tensor) -> Tensor:
        """Of (..., 3 + F) the places only."""
        places = 2.0 * (values[..., :3] - self.low) / (self.high - self.low) - 1.0
        return torch.cat([places, values[..., 3:]], dim=-1)


def schedule_of(config: PolicyConfig) -> DDIMScheduler:
    """Schedule of a policy's noise; clean actions lie in [-1, 1]."""
    return make_schedule(config.steps, config.prediction, clip=True)


def load_policy(folder: Path) -> ChunkPolicy:
    """Read a trained policy.

    Raises:
        CheckpointError: see ``icd_agent.checkpoints.load_checkpoint``.
    """
    return load_checkpoint(folder, KIND, lambda given: ChunkPolicy(PolicyConfig.of(given)))
