"""Chains of recorded episodes instead of generated ones: the ladder's rung below the diffusion."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.checkpoints import load_checkpoint
from icd_agent.diffusion.config import LONGEST, ChainConfig
from icd_agent.diffusion.generate import Generated, Generator, Task
from icd_agent.options import is_count, require
from icd_agent.states import States

KIND: Final = "chains"


@dataclass(frozen=True)
class BankConfig:
    """Sizes of a bank.

    Attributes:
        chains: how many are kept.
        latent: Z.
    """

    chains: int
    latent: int

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for name, value in asdict(self).items():
            require(is_count(value), name, value, "an integer >= 1")


class ChainBank(nn.Module):
    """Latents at equal distances of whole episodes that solved their task.

    Attributes:
        chains: (C, ``LONGEST``, Z).
    """

    chains: Tensor

    def __init__(self, config: BankConfig, chains: Tensor | None = None) -> None:
        """Keep chains; None while a saved bank is loaded."""
        super().__init__()
        self.config = config
        empty = torch.zeros(config.chains, LONGEST, config.latent)
        self.register_buffer("chains", empty if chains is None else chains)

    def nearest(self, chain: Tensor) -> Tensor:
        """The kept chain (L, Z) nearest to one of the same length, in units of their spread.

        Args:
            chain: (L, Z), L = 2^l + 1 up to ``LONGEST``.
        """
        kept = self.chains[:, :: (LONGEST - 1) // (len(chain) - 1)]
        spread = self.chains.std(dim=(0, 1)).clamp(min=1e-6)
        apart = ((kept - chain) / spread).square().mean(dim=(1, 2))
        return kept[int(apart.argmin())]


class Retriever:
    """Generates as its generator does, then takes the nearest recorded chain instead."""

    def __init__(self, generator: Generator, bank: ChainBank) -> None:
        """Put together; the bank holds latents of the generator's autoencoder."""
        self._generator = generator
        self._bank = bank
        self.code = generator.code
        self.config: ChainConfig = generator.config

    def generate(self, task: Task, rng: np.random.Generator) -> Generated:
        """Return the recorded chain nearest to a generated one; it too begins now."""
        found = self._bank.nearest(self._generator.generate(task, rng).latents).clone()
        found[0] = self.code.latents(task.now)
        return Generated(found, None, self.steps(found[None], task.scene)[0])

    def steps(self, chains: Tensor, scene: Tensor) -> Tensor:
        """Predicted control steps (C, L - 1) between consecutive latents (C, L, Z)."""
        return self._generator.steps(chains, scene)


def make_bank(states: States, latents: Tensor, chains: int) -> ChainBank:
    """Keep the first so many whole episodes that solved their task.

    Args:
        states: of recorded episodes.
        latents: (S, Z) of these states.
        chains: how many, at most.
    """
    solved = np.flatnonzero(states.success)[:chains]
    require(len(solved) > 0, "states", "no episode that solved its task", "at least one")
    first, last = states.first[solved], states.first[solved + 1] - 1
    share = np.linspace(0.0, 1.0, LONGEST)
    rows = np.rint(first[:, None] + share * (last - first)[:, None]).astype(np.int64)
    kept = latents[torch.from_numpy(rows)]
    return ChainBank(BankConfig(len(kept), kept.shape[-1]), kept)


def load_bank(folder: Path) -> ChainBank:
    """Read a saved bank.

    Raises:
        CheckpointError: see ``icd_agent.checkpoints.load_checkpoint``.
    """
    return load_checkpoint(folder, KIND, lambda given: ChainBank(BankConfig(**given)))
