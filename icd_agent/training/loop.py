"""The loop: resumable to the bit, with a running average of the weights."""

from __future__ import annotations

import copy
import json
import math
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.training.config import TrainingConfig
from icd_agent.training.initial import initialise
from icd_envs.errors import TrainingError

STATE_NAME: Final = "training.pt"
LOG_NAME: Final = "training.jsonl"

Loss = Callable[[nn.Module, np.random.Generator], dict[str, Tensor]]
"""Draws a batch with the generator and returns terms; the term ``loss`` is minimised."""
Seen = Callable[[int, dict[str, float]], None]
"""Is shown the step and the mean of every term since it was last shown."""


@dataclass(frozen=True)
class Trained:
    """What a run leaves.

    Attributes:
        model: with the averaged weights, in evaluation mode.
        terms: mean of every term over the last lines of progress.
    """

    model: nn.Module
    terms: dict[str, float]

    @property
    def parameters(self) -> int:
        """How many numbers were trained."""
        return sum(value.numel() for value in self.model.parameters())


def train(
    make_model: Callable[[], nn.Module],
    loss: Loss,
    config: TrainingConfig,
    out: Path,
    *,
    device: str = "cpu",
    identity: dict[str, Any] | None = None,
    seen: Seen = lambda step, terms: None,
) -> Trained:
    """Train, or go on with what a killed run left in ``out``; the result is the same to the bit.

    What a step draws depends on the seed and the step's number only, so that no state of a
    generator has to be kept.

    Args:
        make_model: makes the network; its initial weights follow from the seed.
        loss: terms of one batch.
        config: how to train.
        out: folder of the run's state and log.
        device: where to train.
        identity: what else a run depends on (network, data); a state of another one is refused.
        seen: shows progress.

    Raises:
        TrainingError: the loss is not finite, or ``out`` has a state of another run.
    """
    out.mkdir(parents=True, exist_ok=True)
    run = {"training": asdict(config), **(identity or {})}
    with torch.random.fork_rng(devices=[]):  # layers draw weights that are replaced at once
        model = make_model()
    initialise(model, torch.Generator().manual_seed(config.seed))
    model = model.to(device).train()
    average = copy.deepcopy(model)
    optimizer = torch.optim.AdamW(
        model.parameters(),
        config.learning_rate,
        betas=(0.95, 0.999),
        weight_decay=config.weight_decay,
    )
    done, terms = _resume(out / STATE_NAME, run, model, average, optimizer)
    totals: dict[str, float] = {}
    counted = 0
    for step in range(done, config.steps):
        rate = config.learning_rate * _schedule(step, config)
        for group in optimizer.param_groups:
            group["lr"] = rate
        found = loss(model, np.random.default_rng([config.seed, step]))
        now = float(found["loss"].detach())
        if not math.isfinite(now):
            raise TrainingError(
                f"the loss is {now} at step {step}: lower learning_rate, now "
                f"{config.learning_rate}; the state of the last save is in {out}"
            )
        optimizer.zero_grad(set_to_none=True)
        torch.autograd.backward(found["loss"])
        nn.utils.clip_grad_norm_(model.parameters(), config.clip)
        optimizer.step()
        _follow(average, model, min(config.ema, (1 + step) / (10 + step)))
        for name, value in found.items():
            totals[name] = totals.get(name, 0.0) + float(value.detach())
        counted += 1
        if (step + 1) % config.log_every == 0 or step + 1 == config.steps:
            terms = {name: total / counted for name, total in totals.items()}
            totals, counted = {}, 0
            seen(step + 1, terms)
            _log(out / LOG_NAME, step + 1, terms)
        if (step + 1) % config.save_every == 0 or step + 1 == config.steps:
            _save(out / STATE_NAME, run, step + 1, terms, model, average, optimizer)
    return Trained(average.eval(), terms)


def _schedule(step: int, config: TrainingConfig) -> float:
    if step < config.warmup:
        return (step + 1) / config.warmup
    share = (step - config.warmup) / max(1, config.steps - config.warmup)
    return 0.01 + 0.99 * 0.5 * (1.0 + math.cos(math.pi * min(1.0, share)))


@torch.no_grad()
def _follow(average: nn.Module, model: nn.Module, keep: float) -> None:
    for mean, now in zip(average.state_dict().values(), model.state_dict().values(), strict=True):
        if mean.dtype.is_floating_point:
            mean.lerp_(now, 1.0 - keep)
        else:
            mean.copy_(now)


def _log(path: Path, step: int, terms: dict[str, float]) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps({"step": step, **terms}) + "\n")


def _save(
    path: Path,
    run: dict[str, Any],
    step: int,
    terms: dict[str, float],
    model: nn.Module,
    average: nn.Module,
    optimizer: torch.optim.Optimizer,
) -> None:
    """Beside its place, synced and renamed: a kill leaves the last one whole."""
    state = {
        "run": json.dumps(run, sort_keys=True),
        "step": step,
        "terms": terms,
        "model": model.state_dict(),
        "average": average.state_dict(),
        "optimizer": optimizer.state_dict(),
    }
    beside = path.with_suffix(".new")
    with beside.open("wb") as file:
        torch.save(state, file)
        file.flush()
        os.fsync(file.fileno())
    os.replace(beside, path)


def _resume(
    path: Path,
    run: dict[str, Any],
    model: nn.Module,
    average: nn.Module,
    optimizer: torch.optim.Optimizer,
) -> tuple[int, dict[str, float]]:
    if not path.exists():
        return 0, {}
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
        before = json.loads(state["run"])
    except Exception as error:  # zip, pickle and JSON each fail in ways of their own
        raise TrainingError(f"{path} is damaged: {error}: delete it and train again") from error
    if before != json.loads(json.dumps(run)):
        different = sorted(
            name for name in before.keys() | run.keys() if before.get(name) != run.get(name)
        )
        raise TrainingError(
            f"cannot go on with {path.parent}: it was trained with other {', '.join(different)}: "
            "choose another --out"
        )
    model.load_state_dict(state["model"])
    average.load_state_dict(state["average"])
    optimizer.load_state_dict(state["optimizer"])
    return int(state["step"]), dict(state["terms"])
