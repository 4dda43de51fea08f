"""What is loaded is what was saved, or an error says why not (row 21 of the faults)."""

from __future__ import annotations

import hashlib
import json
import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors.torch import save
from torch import nn

from icd_agent.checkpoints import (
    CONFIG_NAME,
    WEIGHTS_NAME,
    check_made_with,
    load_checkpoint,
    save_checkpoint,
)
from icd_envs.errors import CheckpointError
from tests.pickles import MakesFolder


@dataclass(frozen=True)
class Size:
    inputs: int = 4


def build(config: dict[str, Any]) -> nn.Linear:
    return nn.Linear(Size(**config).inputs, 2)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    torch.manual_seed(0)
    save_checkpoint(tmp_path, "toy", build({}), Size(), {"steps": 3})
    return tmp_path


def rewrite(folder: Path, **changes: object) -> None:
    record = json.loads((folder / CONFIG_NAME).read_text())
    (folder / CONFIG_NAME).write_text(json.dumps({**record, **changes}))


def with_weights(folder: Path, content: bytes) -> None:
    (folder / WEIGHTS_NAME).write_bytes(content)
    rewrite(folder, sha256=hashlib.sha256(content).hexdigest())


def test_network_survives_the_files(folder: Path) -> None:
    torch.manual_seed(0)
    saved, loaded = build({}), load_checkpoint(folder, "toy", build)
    assert not loaded.training
    for name, value in saved.state_dict().items():
        assert torch.equal(value, loaded.state_dict()[name])
    record = json.loads((folder / CONFIG_NAME).read_text())
    assert record["about"] == {"steps": 3}
    assert sorted(path.name for path in folder.iterdir()) == [CONFIG_NAME, WEIGHTS_NAME]


def test_trained_weights_may_be_saved_in_half_precision(tmp_path: Path) -> None:
    model = nn.BatchNorm1d(1000)
    model.weight.data += torch.linspace(0.0, 1e-4, 1000)
    model.running_mean += 1.0 + 1e-4  # type: ignore[operator]
    sizes = {}
    for half in (False, True):
        save_checkpoint(tmp_path / str(half), "toy", model, Size(), {}, half=half)
        sizes[half] = (tmp_path / str(half) / WEIGHTS_NAME).stat().st_size
    loaded = load_checkpoint(tmp_path / "True", "toy", lambda config: nn.BatchNorm1d(1000))
    assert loaded.weight.dtype == torch.float32
    assert torch.equal(loaded.weight.data, model.weight.data.half().float())
    assert torch.equal(loaded.running_mean, model.running_mean)  # type: ignore[arg-type]
    assert sizes[False] - sizes[True] == pytest.approx(2 * 2000, abs=100)


@pytest.mark.parametrize("name", [CONFIG_NAME, WEIGHTS_NAME])
def test_missing_file_is_named(folder: Path, name: str) -> None:
    (folder / name).unlink()
    with pytest.raises(CheckpointError, match=name):
        load_checkpoint(folder, "toy", build)


def test_every_flipped_bit_of_the_weights_is_noticed(folder: Path) -> None:
    content = (folder / WEIGHTS_NAME).read_bytes()
    for place in range(0, len(content), 7):
        flipped = bytearray(content)
        flipped[place] ^= 1 << place % 8
        (folder / WEIGHTS_NAME).write_bytes(flipped)
        with pytest.raises(CheckpointError, match="sha256"):
            load_checkpoint(folder, "toy", build)


@pytest.mark.parametrize("content", [b"", b"\x00" * 20, pickle.dumps({"weight": 1})])
def test_what_is_no_safetensors_file_is_refused(folder: Path, content: bytes) -> None:
    with_weights(folder, content)
    with pytest.raises(CheckpointError, match="does not fit"):
        load_checkpoint(folder, "toy", build)


def test_a_pickle_is_never_executed(folder: Path, tmp_path: Path) -> None:
    with_weights(folder, pickle.dumps(MakesFolder(tmp_path / "executed")))
    with pytest.raises(CheckpointError):
        load_checkpoint(folder, "toy", build)
    assert not (tmp_path / "executed").exists()


@pytest.mark.parametrize(
    ("weights", "reason"),
    [
        ({"weight": torch.zeros(2, 4)}, "does not fit"),
        ({"weight": torch.zeros(2, 5), "bias": torch.zeros(2)}, "does not fit"),
        ({"weight": torch.full((2, 4), torch.nan), "bias": torch.zeros(2)}, "weight is not finite"),
    ],
)
def test_weights_that_do_not_fit_or_are_not_finite_are_refused(
    folder: Path, weights: dict[str, torch.Tensor], reason: str
) -> None:
    with_weights(folder, save(weights))
    with pytest.raises(CheckpointError, match=reason):
        load_checkpoint(folder, "toy", build)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"kind": "field"}, "is a 'field'.*expected 'toy'"),
        ({"format": 2}, "format 2"),
        ({"config": {"inputs": 4, "outputs": 3}}, "does not fit"),
        ({"config": {"inputs": 5}}, "does not fit"),
        ({"sha256": 3}, "no checkpoint"),
    ],
)
def test_config_of_something_else_is_refused(
    folder: Path, changes: dict[str, object], reason: str
) -> None:
    rewrite(folder, **changes)
    with pytest.raises(CheckpointError, match=reason):
        load_checkpoint(folder, "toy", build)


def test_config_without_what_the_network_is_built_from_is_refused(folder: Path) -> None:
    with pytest.raises(CheckpointError, match="does not fit its config: KeyError: 'outputs'"):
        load_checkpoint(folder, "toy", lambda config: nn.Linear(4, config["outputs"]))


@pytest.mark.parametrize("part", ["data", "training"])
def test_record_of_the_training_that_is_none_is_refused(folder: Path, part: str) -> None:
    rewrite(folder, about={part: []})
    with pytest.raises(CheckpointError, match=rf"about\.{part} must be a dictionary"):
        check_made_with(folder, "field", folder)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": 1}'])
def test_config_that_is_none_is_refused(folder: Path, text: str) -> None:
    (folder / CONFIG_NAME).write_text(text)
    with pytest.raises(CheckpointError, match=CONFIG_NAME):
        load_checkpoint(folder, "toy", build)
