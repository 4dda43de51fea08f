"""The loop on a network of two numbers: it learns, resumes to the bit, refuses the foreign."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import LOG_NAME, STATE_NAME, train
from icd_envs.errors import InvalidOptionError, TrainingError

CONFIG = TrainingConfig(steps=60, learning_rate=0.05, warmup=5, save_every=10, log_every=7)


def make() -> nn.Module:
    return nn.Linear(3, 1)


def line(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
    """Squared error on y = x . (1, -2, 3) + 4."""
    x = torch.from_numpy(rng.normal(size=(32, 3))).float()
    y = x @ torch.tensor([[1.0], [-2.0], [3.0]]) + 4.0
    return {"loss": (model(x) - y).square().mean(), "size": x.abs().mean()}


def weights(model: nn.Module) -> bytes:
    return b"".join(value.numpy().tobytes() for value in model.state_dict().values())


class KilledError(Exception):
    """Stands for a kill in the middle of a step."""


def test_it_learns_and_leaves_the_average_in_evaluation_mode(tmp_path: Path) -> None:
    config = TrainingConfig(steps=400, learning_rate=0.1, weight_decay=0.0, ema=0.9)
    trained = train(make, line, config, tmp_path)
    assert not trained.model.training
    assert trained.terms["loss"] < 1e-3
    assert trained.terms.keys() == {"loss", "size"}
    torch.testing.assert_close(
        trained.model.weight, torch.tensor([[1.0, -2.0, 3.0]]), atol=0.02, rtol=0
    )


@pytest.mark.parametrize("last", [3, 29, 30, 57])
def test_killed_run_goes_on_to_the_same_bits(tmp_path: Path, last: int) -> None:
    whole = train(make, line, CONFIG, tmp_path / "whole")
    calls = 0

    def until(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        nonlocal calls
        calls += 1
        if calls > last:
            raise KilledError
        return line(model, rng)

    with pytest.raises(KilledError):
        train(make, until, CONFIG, tmp_path / "killed")
    again = train(make, line, CONFIG, tmp_path / "killed")
    assert weights(again.model) == weights(whole.model)


def test_finished_run_is_not_trained_further(tmp_path: Path) -> None:
    first = train(make, line, CONFIG, tmp_path)

    def never(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        raise AssertionError("trained again")

    again = train(make, never, CONFIG, tmp_path)
    assert weights(again.model) == weights(first.model)
    assert again.terms == first.terms


def test_seed_decides_and_global_random_state_does_not(tmp_path: Path) -> None:
    found = []
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        torch.manual_seed(len(found))
        before = torch.random.get_rng_state()
        config = TrainingConfig(steps=5, seed=seed)
        found.append(weights(train(make, line, config, tmp_path / name).model))
        assert torch.equal(torch.random.get_rng_state(), before)
    assert found[0] == found[1] != found[2]


def test_progress_is_shown_and_logged(tmp_path: Path) -> None:
    seen = []
    train(make, line, CONFIG, tmp_path, seen=lambda step, terms: seen.append((step, terms)))
    assert [step for step, _ in seen] == [*range(7, 60, 7), 60]
    lines = (tmp_path / LOG_NAME).read_text().splitlines()
    assert [json.loads(text)["step"] for text in lines] == [step for step, _ in seen]
    assert seen[-1][1]["loss"] < seen[0][1]["loss"]


def test_loss_that_is_not_finite_is_an_error(tmp_path: Path) -> None:
    def broken(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        return {"loss": line(model, rng)["loss"] * float("nan")}

    with pytest.raises(TrainingError, match=r"loss is nan at step 0: train with another --seed"):
        train(make, broken, CONFIG, tmp_path)


def test_state_of_another_run_is_refused_by_name(tmp_path: Path) -> None:
    train(make, line, CONFIG, tmp_path, identity={"data": "a"})
    with pytest.raises(TrainingError, match="other data"):
        train(make, line, CONFIG, tmp_path, identity={"data": "b"})
    longer = TrainingConfig(steps=61)
    with pytest.raises(TrainingError, match="other training"):
        train(make, line, longer, tmp_path, identity={"data": "a"})


@pytest.mark.parametrize("content", [b"", b"PK garbage", b"\x80\x04cos\nsystem\n."])
def test_damaged_state_is_refused_and_never_executed(tmp_path: Path, content: bytes) -> None:
    train(make, line, CONFIG, tmp_path)
    (tmp_path / STATE_NAME).write_bytes(content)
    with pytest.raises(TrainingError, match="is damaged"):
        train(make, line, CONFIG, tmp_path)


@pytest.mark.parametrize(
    "wrong", [{"steps": 0}, {"learning_rate": -1.0}, {"ema": 1.0}, {"clip": float("nan")}]
)
def test_config_refuses_by_name(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        TrainingConfig(**{"steps": 5, **wrong})  # type: ignore[arg-type]
