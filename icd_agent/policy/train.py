"""Train a policy to imitate: the denoising loss of diffusion models over chunks of actions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.policy.config import PolicyConfig
from icd_agent.policy.data import PolicyData, Windows
from icd_agent.policy.policy import KIND, ChunkPolicy, schedule_of
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Seen, Trained
from icd_agent.training.network import Network, train_network

if TYPE_CHECKING:
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler

BATCH: Final = 64


def train_policy(
    data: PolicyData,
    config: PolicyConfig,
    training: TrainingConfig,
    out: Path,
    *,
    about: dict[str, Any],
    device: str = "cpu",
    seen: Seen = lambda step, terms: None,
) -> Trained:
    """Train, or go on with a killed run, and save the weights in ``out`` in half precision.

    Args:
        data: recorded episodes.
        config: sizes of the policy.
        training: how to train.
        out: folder of the run's state, its log and in the end its checkpoint.
        about: where the data come from; part of the run's identity and of the checkpoint.
        device: where to train.
        seen: shows progress.

    Raises:
        TrainingError: see ``icd_agent.training.loop.train``.
    """

    def make() -> ChunkPolicy:
        return ChunkPolicy(config, data.limits)

    schedule = schedule_of(config)

    def loss(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        windows = data.draw(BATCH, rng, device)
        noise = rng.normal(size=windows.actions.shape).astype(np.float32)
        time = rng.integers(config.steps, size=BATCH)
        return policy_loss(
            cast(ChunkPolicy, model),
            schedule,
            windows,
            torch.from_numpy(noise).to(device),
            torch.from_numpy(time).to(device),
        )

    about = {**about, "episodes": data.episodes, "steps": data.steps}
    network = Network(KIND, config, make, half=True)
    return train_network(network, loss, training, out, about=about, device=device, seen=seen)


def policy_loss(
    policy: ChunkPolicy, schedule: DDIMScheduler, windows: Windows, noise: Tensor, time: Tensor
) -> dict[str, Tensor]:
    """Mean squared error of what the policy predicts: the noise, or the clean actions.

    Args:
        policy: in training.
        schedule: of the noise.
        windows: a batch of B.
        noise: (B, H, 3) standard normal.
        time: (B,) steps of the diffusion.
    """
    noisy = schedule.add_noise(windows.actions, noise, cast(torch.IntTensor, time))
    predicted = policy(noisy, time, policy.condition(windows.seen))
    wanted = noise if policy.config.prediction == "epsilon" else windows.actions
    return {"loss": (predicted - wanted).square().mean()}
