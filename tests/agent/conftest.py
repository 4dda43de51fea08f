"""What tests of networks share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import torch

from icd_agent.latent.train import train_latent
from icd_agent.training.config import TrainingConfig
from tests.agent.toy_states import LATENT, toy_states


@pytest.fixture(scope="package", autouse=True)
def one_thread() -> Iterator[None]:
    """Networks this small are trained faster so, and on a busy machine several times faster."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="package")
def toy_latent(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of an autoencoder of the toy's states."""
    out = tmp_path_factory.mktemp("latent")
    config = TrainingConfig(steps=500, learning_rate=5e-3, warmup=20, log_every=50, ema=0.98)
    train_latent(toy_states(), LATENT, config, out, about={})
    return out
