"""Settings of a training run. Imports no torch."""

from __future__ import annotations

from dataclasses import dataclass

from icd_agent.options import is_count, is_finite, is_positive, require


@dataclass(frozen=True)
class TrainingConfig:
    """How a network is trained.

    Attributes:
        steps: optimiser steps in all.
        learning_rate: of AdamW at its peak.
        warmup: steps over which it rises; it then falls along half a cosine to a hundredth.
        weight_decay: of AdamW.
        clip: largest norm of a gradient.
        ema: share of the running average of the weights that is kept at each step; the average
            is what is saved in the end.
        seed: of initial weights and all data.
        save_every: steps between states that a killed run can go on from.
        log_every: steps between lines of progress.
    """

    steps: int
    learning_rate: float = 1e-3
    warmup: int = 100
    weight_decay: float = 1e-4
    clip: float = 1.0
    ema: float = 0.995
    seed: int = 0
    save_every: int = 200
    log_every: int = 20

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for name in ("steps", "save_every", "log_every"):
            require(is_count(getattr(self, name)), name, getattr(self, name), "an integer >= 1")
        for name in ("learning_rate", "clip"):
            require(is_positive(getattr(self, name)), name, getattr(self, name), "a number > 0")
        for name in ("warmup", "weight_decay"):
            value = getattr(self, name)
            require(is_finite(value) and value >= 0, name, value, "a number >= 0")
        good = type(self.seed) is int and self.seed >= 0
        require(good, "seed", self.seed, "an integer >= 0")
        require(is_finite(self.ema) and 0 <= self.ema < 1, "ema", self.ema, "a number in [0, 1)")
