"""One small training run: ``python -m tests.faults.training_run KIND OUT [STEP TO DIE AT]``."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import torch

from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.train import train_diffusion
from icd_agent.field.train import train_field
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.latent.train import train_latent
from icd_agent.training.config import TrainingConfig
from icd_agent.training.initial import initialise
from icd_agent.training.loop import Seen
from tests.agent.field.small import SMALL, small_data
from tests.agent.toy_states import toy_states

LATENT = LatentConfig(3, 4, 12, latent=8, groups=6, neighbours=4, width=16, decoder_width=16)
DENOISER = DiffusionConfig(8, 4, 12, 2, places=4, width=48, layers=2, heads=2)
TRAINING = TrainingConfig(steps=60, warmup=5, save_every=7, log_every=1)


def _field(out: Path, seen: Seen, device: str) -> None:
    train_field(small_data(), SMALL, TRAINING, out, about={}, device=device, seen=seen)


def _latent(out: Path, seen: Seen, device: str) -> None:
    train_latent(toy_states(), LATENT, TRAINING, out, about={}, device=device, seen=seen)


def _diffusion(out: Path, seen: Seen, device: str) -> None:
    latent = LatentModel(LATENT).eval()
    initialise(latent, torch.Generator().manual_seed(0))
    train_diffusion(
        toy_states(), latent, DENOISER, TRAINING, out, about={}, device=device, seen=seen
    )


RUNS: dict[str, Callable[[Path, Seen, str], None]] = {
    "field": _field,
    "latent": _latent,
    "diffusion": _diffusion,
}


def dying_at(last: int | None) -> Seen:
    """Kills this process in that step, before it is written down."""

    def seen(step: int, terms: dict[str, float]) -> None:
        if step == last:
            os.kill(os.getpid(), signal.SIGKILL)

    return seen


if __name__ == "__main__":
    kind, out, *last = sys.argv[1:]
    RUNS[kind](Path(out), dying_at(int(last[0]) if last else None), "cpu")
