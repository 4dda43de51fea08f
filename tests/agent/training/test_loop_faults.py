"""What a training leaves when it goes wrong: the last good state, and one line that says why."""

from __future__ import annotations

import io
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from icd_agent.checkpoints import save_checkpoint
from icd_agent.training.loop import LOG_NAME, STATE_NAME, Loss, train
from icd_agent.training.resumed import differences
from icd_envs.errors import CheckpointError, TrainingError
from tests.agent.training.test_loop import CONFIG, KilledError, line, make


def full(*arguments: object) -> None:
    raise OSError(28, "No space left on device")


def until(step: int) -> Loss:
    """The loss, but the run is killed after so many steps."""
    calls = 0

    def loss(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        nonlocal calls
        calls += 1
        if calls > step:
            raise KilledError
        return line(model, rng)

    return loss


class _Steep(torch.autograd.Function):
    """Zero, with a gradient that is not a number."""

    @staticmethod
    def forward(ctx: object, x: Tensor) -> Tensor:
        return torch.zeros_like(x)

    @staticmethod
    def backward(ctx: object, grad: Tensor) -> Tensor:
        return grad * float("nan")


def test_a_gradient_that_is_not_finite_ends_the_run_and_the_last_save_stays_good(
    tmp_path: Path,
) -> None:
    calls = 0

    def broken(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        nonlocal calls
        calls += 1
        found = line(model, rng)
        return {"loss": found["loss"] + _Steep.apply(found["loss"])} if calls == 15 else found

    with pytest.raises(TrainingError, match="norm of the gradient is nan at step 14: train with"):
        train(make, broken, CONFIG, tmp_path)
    state = torch.load(tmp_path / STATE_NAME, weights_only=True)
    assert state["step"] == 10
    assert all(value.isfinite().all() for value in state["model"].values())


def test_weights_that_are_not_finite_are_never_saved_over_good_ones(tmp_path: Path) -> None:
    def with_scale() -> nn.Module:
        network = make()
        network.register_buffer("scale", torch.ones(1))
        return network

    def broken(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        if (tmp_path / STATE_NAME).exists():  # after the first save
            model.get_buffer("scale").fill_(float("inf"))
        return line(model, rng)

    with pytest.raises(TrainingError, match="scale is not finite at step 19"):
        train(with_scale, broken, CONFIG, tmp_path)
    state = torch.load(tmp_path / STATE_NAME, weights_only=True)
    assert state["step"] == 10
    assert state["model"]["scale"] == 1


@pytest.mark.parametrize(
    ("value", "half", "message"),
    [
        (float("nan"), False, "weight is not finite: not saved"),
        (1e5, True, "weight is not finite in half precision, which ends at 65504"),
    ],
)
def test_a_checkpoint_that_would_not_load_is_not_written(
    tmp_path: Path, value: float, half: bool, message: str
) -> None:
    network = nn.Linear(2, 2)
    save_checkpoint(tmp_path, "toy", network, CONFIG, {}, half=half)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with torch.no_grad():
        network.weight[0, 0] = value
    with pytest.raises(CheckpointError, match=message):
        save_checkpoint(tmp_path, "toy", network, CONFIG, {}, half=half)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_full_disk_leaves_the_last_state_and_the_run_goes_on_when_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = train(make, line, CONFIG, tmp_path / "whole")
    out = tmp_path / "full"
    with pytest.raises(KilledError):
        train(make, until(15), CONFIG, out)
    before = (out / STATE_NAME).read_bytes()
    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(TrainingError, match=r"cannot write .*No space left.*free some space"):
            train(make, line, CONFIG, out)
    assert (out / STATE_NAME).read_bytes() == before
    assert sorted(path.name for path in out.iterdir()) == [LOG_NAME, STATE_NAME]
    again = train(make, line, CONFIG, out)
    assert torch.equal(again.model.weight, whole.model.weight)


def test_a_full_disk_leaves_the_checkpoint_that_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_checkpoint(tmp_path, "toy", nn.Linear(2, 2), CONFIG, {})
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(CheckpointError, match=r"No space left.*free some space"):
        save_checkpoint(tmp_path, "toy", nn.Linear(2, 2), CONFIG, {})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_that_cannot_be_made_is_an_error_of_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(TrainingError, match=r"cannot write .*file"):
        train(make, line, CONFIG, tmp_path / "file" / "run")


def test_a_run_that_goes_on_logs_every_step_once(tmp_path: Path) -> None:
    config = replace(CONFIG, log_every=1)
    with pytest.raises(KilledError):
        train(make, until(17), config, tmp_path)
    with (tmp_path / LOG_NAME).open("a") as file:
        file.write('{"step": 18, "lo')  # a kill in the middle of a line
    train(make, line, config, tmp_path)
    lines = (tmp_path / LOG_NAME).read_text().splitlines()
    assert [json.loads(text)["step"] for text in lines] == list(range(1, 61))


def test_a_state_of_another_shape_is_refused_in_one_line(tmp_path: Path) -> None:
    train(make, line, CONFIG, tmp_path)
    with pytest.raises(TrainingError, match=r"training.pt does not fit the network(.|\n)*mismatch"):
        train(lambda: nn.Linear(4, 1), line, CONFIG, tmp_path)


def test_a_state_without_its_parts_is_refused(tmp_path: Path) -> None:
    train(make, line, CONFIG, tmp_path)
    state = torch.load(tmp_path / STATE_NAME, weights_only=True)
    for name in ("run", "model", "optimizer", "step"):
        content = io.BytesIO()
        torch.save({key: value for key, value in state.items() if key != name}, content)
        (tmp_path / STATE_NAME).write_bytes(content.getvalue())
        with pytest.raises(TrainingError, match=r"training\.pt"):
            train(make, line, CONFIG, tmp_path)


def test_tuples_and_lists_are_the_same_run(tmp_path: Path) -> None:
    train(make, line, CONFIG, tmp_path, identity={"widths": (1, 2)})
    train(make, line, CONFIG, tmp_path, identity={"widths": [1, 2]})


def test_refusal_names_every_value_that_differs_and_both_of_its_values(tmp_path: Path) -> None:
    train(make, line, CONFIG, tmp_path, identity={"data": {"env": "a", "seed": 1}})
    with pytest.raises(TrainingError) as refused:
        train(make, line, replace(CONFIG, steps=61), tmp_path, identity={"data": {"env": "b"}})
    for part in ('data.env ("a" there, "b" now)', "data.seed (1 there, nothing now)"):
        assert part in str(refused.value)
    assert "training.steps (60 there, 61 now): choose another --out" in str(refused.value)


def test_equal_records_do_not_differ() -> None:
    assert differences({"a": {"b": [1]}}, {"a": {"b": [1]}}) == []
    assert differences({"a": {"b": 1}}, {"a": 1}) == ['a ({"b": 1} there, 1 now)']


def test_the_model_that_is_returned_is_on_the_cpu(tmp_path: Path) -> None:
    trained = train(make, line, CONFIG, tmp_path)
    assert {value.device.type for value in trained.model.state_dict().values()} == {"cpu"}
