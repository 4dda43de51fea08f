"""The conditional one-dimensional U-Net of Diffusion Policy (Chi et al., RSS 2023), by FiLM."""

from __future__ import annotations

import math
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from icd_agent.policy.config import GROUPS, PolicyConfig


class ConditionalUNet(nn.Module):
    """Denoises a chunk of actions, steered at every layer by step and condition."""

    def __init__(self, config: PolicyConfig, actions: int, condition: int) -> None:
        """Build the layers.

        Args:
            config: sizes.
            actions: numbers per action.
            condition: numbers of the condition.
        """
        super().__init__()
        time, widths = config.time_width, config.widths
        self.time = nn.Sequential(nn.Linear(time, 4 * time), nn.Mish(), nn.Linear(4 * time, time))
        self.frequencies = time // 2

        def block(before: int, after: int) -> _Residual:
            return _Residual(before, after, condition + time, config.kernel)

        self.down = nn.ModuleList()
        for before, after in pairwise((actions, *widths)):
            self.down.append(nn.ModuleList([block(before, after), block(after, after)]))
        self.shrink = nn.ModuleList(
            nn.Conv1d(width, width, 3, stride=2, padding=1) for width in widths[:-1]
        )
        self.middle = nn.ModuleList(block(widths[-1], widths[-1]) for _ in range(2))
        self.up = nn.ModuleList()
        self.grow = nn.ModuleList()
        for before, after in pairwise(reversed(widths)):
            self.grow.append(nn.Conv1d(before, after, 3, padding=1))
            self.up.append(nn.ModuleList([block(2 * after, after), block(after, after)]))
        self.last = _Convolved(widths[0], widths[0], config.kernel)
        self.out = nn.Conv1d(widths[0], actions, 1)

    def forward(self, noisy: Tensor, time: Tensor, condition: Tensor) -> Tensor:
        """The prediction (B, H, A).

        Args:
            noisy: (B, H, A) actions.
            time: (B,) step of the diffusion.
            condition: (B, C).
        """
        steered = torch.cat([condition, self.time(self._waves(time))], dim=-1)
        values, kept = noisy.transpose(1, 2), []
        for i, blocks in enumerate(self.down):
            for block in blocks:  # type: ignore[attr-defined]  # a ModuleList
                values = block(values, steered)
            if i < len(self.shrink):
                kept.append(values)
                values = self.shrink[i](values)
        for block in self.middle:
            values = block(values, steered)
        for grow, blocks in zip(self.grow, self.up, strict=True):
            values = grow(functional.interpolate(values, scale_factor=2.0, mode="nearest"))
            values = torch.cat([values, kept.pop()], dim=1)
            for block in blocks:  # type: ignore[attr-defined]
                values = block(values, steered)
        found: Tensor = self.out(self.last(values)).transpose(1, 2)
        return found

    def _waves(self, time: Tensor) -> Tensor:
        decay = math.log(10_000.0) / max(1, self.frequencies - 1)
        rates = torch.exp(-decay * torch.arange(self.frequencies, device=time.device))
        angles = time[:, None] * rates
        return torch.cat([angles.sin(), angles.cos()], dim=-1)


class _Convolved(nn.Sequential):
    def __init__(self, before: int, after: int, kernel: int) -> None:
        super().__init__(
            nn.Conv1d(before, after, kernel, padding=kernel // 2),
            nn.GroupNorm(GROUPS, after),
            nn.Mish(),
        )


class _Residual(nn.Module):
    """Two convolutions; what lies between is scaled and shifted by the condition."""

    def __init__(self, before: int, after: int, condition: int, kernel: int) -> None:
        super().__init__()
        self.first = _Convolved(before, after, kernel)
        self.steer = nn.Sequential(nn.Mish(), nn.Linear(condition, 2 * after))
        self.second = _Convolved(after, after, kernel)
        self.past = nn.Conv1d(before, after, 1) if before != after else nn.Identity()

    def forward(self, values: Tensor, condition: Tensor) -> Tensor:
        scale, shift = self.steer(condition)[..., None].chunk(2, dim=1)
        found: Tensor = self.second((1.0 + scale) * self.first(values) + shift)
        return found + self.past(values)
