"""What every training from demonstrations is told."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from icd_envs.tasks.problem import Split


@dataclass(frozen=True)
class TrainingOrder:
    """An order to train something.

    Attributes:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        out: of the run; a killed one goes on.
        device: where to train.
        steps: optimiser steps in all.
        episodes: how many are used, at most.
        seed: of initial weights and data.
        split: the scenes that the demonstrations must be of; "test" only for what is never measured
            in test scenes.
    """

    env_id: str
    data: Path
    out: Path
    device: str
    steps: int
    episodes: int
    seed: int
    split: Split = "train"

    def part(self, name: str, steps: int | None = None) -> Self:
        """The order for a part of it: a folder below, other steps if given."""
        return replace(self, out=self.out / name, steps=self.steps if steps is None else steps)
