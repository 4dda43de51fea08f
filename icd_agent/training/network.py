"""Train a network and save it with the record of how."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from torch import nn

from icd_agent.checkpoints import save_checkpoint
from icd_agent.locking import alone
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Loss, Seen, Trained, train

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


@dataclass(frozen=True)
class Network:
    """What is trained.

    Attributes:
        kind: name in its checkpoint.
        config: frozen dataclass that it is built from.
        make: makes it; its initial weights follow from the seed of the run.
        half: save it in half precision.
    """

    kind: str
    config: DataclassInstance
    make: Callable[[], nn.Module]
    half: bool = False


def train_network(
    network: Network,
    loss: Loss,
    training: TrainingConfig,
    out: Path,
    *,
    about: dict[str, Any],
    device: str,
    seen: Seen,
) -> Trained:
    """Train, or go on with a killed run, and save the weights in ``out``.

    Args:
        network: what is trained.
        loss: terms of one batch.
        training: how to train.
        out: folder of the run's state, its log and in the end its checkpoint.
        about: what the data are; part of the run's identity and of the checkpoint.
        device: where to train.
        seen: shows progress.

    Raises:
        TrainingError: see ``icd_agent.training.loop.train``, or another training is in ``out``.
    """
    identity = {"network": asdict(network.config), "data": about}
    with alone(out):
        trained = train(
            network.make, loss, training, out, device=device, identity=identity, seen=seen
        )
        record = {"data": about, "training": asdict(training), "terms": trained.terms}
        save_checkpoint(out, network.kind, trained.model, network.config, record, half=network.half)
    return trained
