"""The loop: resumable to the bit, with a running average of the weights."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.checkpoints import not_finite
from icd_agent.replacing import cannot_write
from icd_agent.training.config import TrainingConfig
from icd_agent.training.initial import initialise
from icd_agent.training.resumed import cut_log
from icd_agent.training.state import read_state, save_state
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
        model: with the averaged weights, in evaluation mode, on the CPU.
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
        TrainingError: loss, gradient or weights are not finite, ``out`` cannot be written, or has a
            damaged state or one of another run. The last state that was saved stays as it is.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TrainingError(cannot_write(out, error)) from error
    run = json.loads(json.dumps({"training": asdict(config), **(identity or {})}))
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
    cut_log(out / LOG_NAME, done)
    unseen: list[dict[str, Tensor]] = []
    for step in range(done, config.steps):
        rate = config.learning_rate * _schedule(step, config)
        for group in optimizer.param_groups:
            group["lr"] = rate
        found = loss(model, np.random.default_rng([config.seed, step]))
        optimizer.zero_grad(set_to_none=True)
        torch.autograd.backward(found["loss"])
        norm = nn.utils.clip_grad_norm_(model.parameters(), config.clip)
        now = {"loss": float(found["loss"].detach()), "norm of the gradient": float(norm)}
        for name, value in now.items():
            if not math.isfinite(value):
                raise _diverged(f"the {name} is {value}", step, config, out)
        optimizer.step()
        _follow(average, model, min(config.ema, (1 + step) / (10 + step)))
        unseen.append({name: value.detach() for name, value in found.items()})
        if (step + 1) % config.log_every == 0 or step + 1 == config.steps:
            terms = _means(unseen)
            unseen = []
            seen(step + 1, terms)
            _log(out / LOG_NAME, step + 1, terms)
        if (step + 1) % config.save_every == 0 or step + 1 == config.steps:
            if (bad := not_finite(model.state_dict())) is not None:
                raise _diverged(f"{bad} is not finite", step, config, out)
            _save(out / STATE_NAME, run, step + 1, terms, model, average, optimizer)
    return Trained(average.eval().to("cpu"), terms)


def _diverged(what: str, step: int, config: TrainingConfig, out: Path) -> TrainingError:
    return TrainingError(
        f"{what} at step {step}: train with another --seed and another --out, or from Python with "
        f"a lower learning_rate, now {config.learning_rate}; the last save in {out} is good"
    )


def _means(unseen: list[dict[str, Tensor]]) -> dict[str, float]:
    """Mean of every term; they are read only now, because reading waits for the device."""
    totals: dict[str, float] = {}
    for found in unseen:
        for name, value in found.items():
            totals[name] = totals.get(name, 0.0) + float(value)
    return {name: total / len(unseen) for name, total in totals.items()}


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
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"step": step, **terms}) + "\n")
    except OSError as error:
        raise TrainingError(cannot_write(path, error)) from error


def _save(
    path: Path,
    run: dict[str, Any],
    step: int,
    terms: dict[str, float],
    model: nn.Module,
    average: nn.Module,
    optimizer: torch.optim.Optimizer,
) -> None:
    state = {
        "step": step,
        "terms": terms,
        "model": model.state_dict(),
        "average": average.state_dict(),
        "optimizer": optimizer.state_dict(),
    }
    save_state(path, run, state)


def _resume(
    path: Path,
    run: dict[str, Any],
    model: nn.Module,
    average: nn.Module,
    optimizer: torch.optim.Optimizer,
) -> tuple[int, dict[str, float]]:
    """Step and terms of the state that is there; the networks then have its weights."""
    state = read_state(path, run)
    if state is None:
        return 0, {}
    try:
        model.load_state_dict(state["model"])
        average.load_state_dict(state["average"])
        optimizer.load_state_dict(state["optimizer"])
        return int(state["step"]), dict(state["terms"])
    except Exception as error:  # keys, shapes and types each fail in ways of their own
        raise TrainingError(
            f"{path} does not fit the network: {error}: delete it and train again, or go on with "
            "the version of this project that wrote it"
        ) from error
