"""The loop on a network of two numbers: it learns, resumes to the bit, refuses the foreign."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import LOG_NAME, STATE_NAME, train
from icd_envs.api import Float64Array
from icd_envs.errors import InvalidOptionError, TrainingError
from tests.killing import KilledError
from tests.pickles import MakesFolder

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


class Walk(NamedTuple):
    """One number of a network before every step and after the last, and its average."""

    path: Float64Array
    average: float


def walk(out: Path, lengths: Sequence[float], **changes: float) -> Walk:
    """Train on gradients of one direction and these lengths, on which AdamW steps downhill."""
    config = TrainingConfig(**{"steps": len(lengths), "weight_decay": 0.0, **changes})  # type: ignore[arg-type]
    model, path = make(), []

    def slope(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        path.append(model.bias.item())
        length = lengths[len(path) - 1]
        return {"loss": 0.5 * length * (model.weight.sum() + model.bias.sum())}

    average = train(lambda: model, slope, config, out).model.bias
    return Walk(np.array([*path, model.bias.item()]), average.item())


def test_it_learns_and_leaves_the_average_in_evaluation_mode(tmp_path: Path) -> None:
    config = TrainingConfig(steps=400, learning_rate=0.1, weight_decay=0.0, ema=0.9)
    trained = train(make, line, config, tmp_path)
    assert not trained.model.training
    assert trained.terms["loss"] < 1e-3
    assert trained.terms.keys() == {"loss", "size"}
    torch.testing.assert_close(
        trained.model.weight, torch.tensor([[1.0, -2.0, 3.0]]), atol=0.02, rtol=0
    )


def test_the_learning_rate_rises_then_falls_along_half_a_cosine(tmp_path: Path) -> None:
    found = walk(tmp_path, [1.0] * 12, learning_rate=0.1, warmup=4)
    falling = [1.0, 0.9623, 0.8550, 0.6944, 0.5050, 0.3156, 0.1550, 0.0477]  # to 0.01 in the end
    expected = 0.1 * np.array([0.25, 0.5, 0.75, 1.0, *falling])
    np.testing.assert_allclose(-np.diff(found.path), expected, atol=1e-5)


def test_a_gradient_counts_up_to_its_limit(tmp_path: Path) -> None:
    def end(name: str, *lengths: float, clip: float) -> float:
        return walk(tmp_path / name, lengths, warmup=1, learning_rate=0.1, clip=clip).path[-1]

    unit = end("unit", 2.0, 2.0, 2.0, clip=2.0)
    assert end("long", 2.0, 200.0, 20.0, clip=2.0) == pytest.approx(unit, abs=1e-5)
    assert abs(end("free", 2.0, 200.0, 20.0, clip=1e3) - unit) > 1e-2
    short = end("short", 1.9, 1.0, 0.1, clip=2.0)
    assert short == pytest.approx(end("short and free", 1.9, 1.0, 0.1, clip=1e3), abs=1e-5)
    assert abs(short - unit) > 1e-2


def test_what_is_left_is_the_running_average_which_forgets_its_beginning(tmp_path: Path) -> None:
    found = walk(tmp_path / "two", [1.0] * 2, warmup=1, learning_rate=0.1, ema=0.15)
    kept = [0.1 * 0.15, 0.9 * 0.15, 0.85]  # a tenth at first, then 0.15: less than 2 / 11
    assert found.average == pytest.approx(float(np.dot(kept, found.path)), abs=1e-6)
    found = walk(tmp_path / "none", [1.0] * 2, ema=0.0)
    assert found.average == found.path[-1]


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


@pytest.mark.parametrize("content", [b"", b"PK garbage"])
def test_damaged_state_is_refused(tmp_path: Path, content: bytes) -> None:
    train(make, line, CONFIG, tmp_path)
    (tmp_path / STATE_NAME).write_bytes(content)
    with pytest.raises(TrainingError, match="is damaged"):
        train(make, line, CONFIG, tmp_path)


def test_a_pickle_in_the_state_is_never_executed(tmp_path: Path) -> None:
    torch.save(MakesFolder(tmp_path / "executed"), tmp_path / STATE_NAME)
    with pytest.raises(TrainingError, match="is damaged"):
        train(make, line, CONFIG, tmp_path)
    assert not (tmp_path / "executed").exists()


@pytest.mark.parametrize(
    "wrong", [{"steps": 0}, {"learning_rate": -1.0}, {"ema": 1.0}, {"clip": float("nan")}]
)
def test_config_refuses_by_name(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        TrainingConfig(**{"steps": 5, **wrong})  # type: ignore[arg-type]
