"""Train the denoiser on latents of recorded states."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.checkpoints import load_checkpoint
from icd_agent.diffusion.chains import ChainData, Chains
from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import GIVEN, Denoiser
from icd_agent.diffusion.schedule import make_schedule
from icd_agent.latent.model import LatentModel
from icd_agent.latent.principal import principal
from icd_agent.states import States
from icd_agent.training.config import TrainingConfig
from icd_agent.training.loop import Seen, Trained
from icd_agent.training.network import Network, train_network

if TYPE_CHECKING:
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler

KIND: Final = "diffusion"
BATCH: Final = 64
CHUNK: Final = 512
"""States that are encoded at once."""
STATISTICS: Final = 4096
"""States that the code of subgoals is taken from."""


def train_diffusion(
    states: States,
    latent: LatentModel,
    config: DiffusionConfig,
    training: TrainingConfig,
    out: Path,
    *,
    about: dict[str, Any],
    device: str = "cpu",
    seen: Seen = lambda step, terms: None,
) -> Trained:
    """Train, or go on with a killed run, and save the weights in ``out``.

    Args:
        states: of recorded episodes.
        latent: trained autoencoder, in evaluation mode; stays as it is.
        config: sizes of the network.
        training: how to train.
        out: folder of the run's state, its log and in the end its checkpoint.
        about: where the data come from; part of the run's identity and of the checkpoint.
        device: where to train.
        seen: shows progress.

    Raises:
        TrainingError: see ``icd_agent.training.loop.train``.
    """
    latents = encode_states(states, latent)
    code = fit_code(states, latents, config, np.random.default_rng([training.seed]))
    data = ChainData(states, latents, code, config.scene_size)
    schedule = make_schedule(config.steps)

    def loss(model: nn.Module, rng: np.random.Generator) -> dict[str, Tensor]:
        chains = data.draw(BATCH, rng, device)
        noise = rng.normal(size=chains.clean.shape).astype(np.float32)
        time = rng.integers(config.steps, size=BATCH)
        return denoising_loss(
            model,
            schedule,
            chains,
            torch.from_numpy(noise).to(device),
            torch.from_numpy(time).to(device),
        )

    about = {**about, "episodes": len(states.success), "states": len(states.step)}
    # A copy: the network's moves to the device, while chains are still coded here.
    network = Network(KIND, config, lambda: Denoiser(config, deepcopy(code)), half=True)
    return train_network(network, loss, training, out, about=about, device=device, seen=seen)


def fit_code(
    states: States, latents: Tensor, config: DiffusionConfig, rng: np.random.Generator
) -> SubgoalCode:
    """How subgoals are coded: places as seen from where their episodes begin.

    Args:
        states: of recorded episodes.
        latents: (S, Z) of these states.
        config: sizes.
        rng: draws the states that components are taken from.
    """
    rows = states.draw(STATISTICS, rng)
    placed = states.frame(states.first[states.episode[rows]]).place(states.clouds[rows])
    clouds = placed.astype(np.float32)
    code = SubgoalCode(config, principal(clouds, config.places) if config.places else None)
    code.fit(latents[torch.from_numpy(rows)], torch.from_numpy(clouds))
    return code


def denoising_loss(
    model: nn.Module, schedule: DDIMScheduler, chains: Chains, noise: Tensor, time: Tensor
) -> dict[str, Tensor]:
    """Squared errors of the clean subgoals that are not given: of latents, and of places.

    The network sees every number with unit variance, but those that hardly vary hardly matter:
    errors count by the variance that is behind them, so that they are those of what is decoded.

    Args:
        model: a ``Denoiser``.
        schedule: of the noise.
        chains: what is to be found, and what is known.
        noise: (B, L, V) standard normal.
        time: (B,) steps of the diffusion.
    """
    given = (chains.known.kinds == GIVEN)[..., None]
    noisy = schedule.add_noise(chains.clean, noise, cast(torch.IntTensor, time))
    noisy = torch.where(given, chains.clean, noisy)
    code = cast(Denoiser, model).code
    squared = (model(noisy, time, chains.known) - chains.clean).square() * code.shares
    error, places = squared[..., : code.latent].sum(-1), squared[..., code.latent :].sum(-1)
    wanted = ~given[..., 0]
    noisiest = wanted & (time >= 0.9 * len(schedule.alphas_cumprod))[:, None]
    return {
        "loss": (error + places)[wanted].mean(),
        "latents": error[wanted].mean(),
        "places": places[wanted].mean(),
        "from_noise": (error * noisiest).sum() / noisiest.sum().clamp(min=1),
    }


def encode_states(states: States, latent: LatentModel) -> Tensor:
    """Latents (S, Z) of recorded states."""
    canonical = torch.from_numpy(states.canonical)
    found = []
    with torch.no_grad():
        for first in range(0, len(states.step), CHUNK):
            features = states.features[first : first + CHUNK].astype(np.float32)
            found.append(latent.encode(torch.from_numpy(features), canonical))
    return torch.cat(found)


def load_diffusion(folder: Path) -> Denoiser:
    """Read a trained denoiser.

    Raises:
        CheckpointError: see ``icd_agent.checkpoints.load_checkpoint``.
    """
    return load_checkpoint(folder, KIND, lambda given: Denoiser(DiffusionConfig(**given)))
