"""One small training run, to be killed: ``python -m tests.faults.training_run KIND OUT``."""

from __future__ import annotations

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
from tests.agent.field.small import SMALL, small_data
from tests.agent.toy_states import toy_states

LATENT = LatentConfig(3, 4, 12, latent=8, groups=6, neighbours=4, width=16, decoder_width=16)
DENOISER = DiffusionConfig(8, 4, 12, 2, places=4, width=48, layers=2, heads=2)
TRAINING = TrainingConfig(steps=60, warmup=5, save_every=7, log_every=1)


def _field(out: Path) -> None:
    train_field(small_data(), SMALL, TRAINING, out, about={})


def _latent(out: Path) -> None:
    train_latent(toy_states(), LATENT, TRAINING, out, about={})


def _diffusion(out: Path) -> None:
    latent = LatentModel(LATENT).eval()
    initialise(latent, torch.Generator().manual_seed(0))
    train_diffusion(toy_states(), latent, DENOISER, TRAINING, out, about={})


RUNS: dict[str, Callable[[Path], None]] = {
    "field": _field,
    "latent": _latent,
    "diffusion": _diffusion,
}

if __name__ == "__main__":
    RUNS[sys.argv[1]](Path(sys.argv[2]))
