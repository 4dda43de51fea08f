"""Training on three scenes: it learns, goes on to the same weights, and is read back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import torch

from icd_agent.field.data import FieldData
from icd_agent.field.supervision import BESIDE
from icd_agent.field.train import load_field, train_field
from icd_agent.training.config import TrainingConfig
from icd_envs.errors import CheckpointError, TrainingError
from tests.agent.field.small import SMALL, small_data
from tests.killing import KilledError, kill_at

CONFIG = TrainingConfig(steps=12, learning_rate=3e-3, warmup=2, save_every=5, log_every=6)


@pytest.fixture(scope="module")
def data() -> FieldData:
    return small_data()


@pytest.fixture(scope="module")
def trained(data: FieldData, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("whole")
    train_field(data, SMALL, CONFIG, out, about={"env": "toy"})
    return out


def test_batches_repeat_and_companions_are_near(data: FieldData) -> None:
    clouds, truth, (first, second) = data.draw(4, 30, np.random.default_rng(5))
    again = data.draw(4, 30, np.random.default_rng(5))
    assert torch.equal(again[0], clouds)
    assert torch.equal(again[1].points, truth.points)
    assert clouds.shape == (4, 300, 3)
    assert truth.points.shape == truth.gradient.shape == (4, 60, 3)
    apart = (truth.points[:, first[:30]] - truth.points[:, second[:30]]).norm(dim=-1)
    assert float(apart.max()) <= BESIDE * 1.001
    assert len(first) == len(second) == 90


@pytest.mark.parametrize("scope", ["local", "global"])
def test_it_learns(data: FieldData, tmp_path: Path, scope: Literal["local", "global"]) -> None:
    seen: list[float] = []
    config = TrainingConfig(steps=60, learning_rate=3e-3, warmup=5, log_every=20)
    sizes = replace(SMALL, scope=scope)
    train_field(
        data, sizes, config, tmp_path, about={}, seen=lambda _, terms: seen.append(terms["loss"])
    )
    assert seen[-1] < 0.6 * seen[0]


def test_a_killed_run_goes_on_to_the_same_weights(
    data: FieldData, trained: Path, tmp_path: Path
) -> None:
    with pytest.raises(KilledError):
        train_field(data, SMALL, CONFIG, tmp_path, about={"env": "toy"}, seen=kill_at(6))
    assert not (tmp_path / "model.safetensors").exists()
    train_field(data, SMALL, CONFIG, tmp_path, about={"env": "toy"})
    for name in ("config.json", "model.safetensors"):
        assert (tmp_path / name).read_bytes() == (trained / name).read_bytes()


def test_other_data_are_refused(data: FieldData, trained: Path) -> None:
    with pytest.raises(TrainingError, match="data"):
        train_field(data, SMALL, CONFIG, trained, about={"env": "another"})


def test_weights_are_read_back(trained: Path, tmp_path: Path) -> None:
    field = load_field(trained)
    assert field.config == SMALL
    assert not field.training
    with pytest.raises(CheckpointError):
        load_field(tmp_path)
