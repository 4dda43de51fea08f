"""Settings that could only fail later, in the middle of a run, are refused when they are made."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from icd_agent.diffusion.config import ChainConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.diffusion.generate import Generator
from icd_agent.diffusion.schedule import check_denoising, make_schedule
from icd_agent.latent.model import LatentModel
from icd_agent.policy.config import PolicyConfig
from icd_agent.training.config import TrainingConfig
from icd_agent.training.device import check_device
from icd_envs.errors import InvalidOptionError
from tests.faults.training_run import DENOISER, LATENT

POLICY = PolicyConfig("points", 0, 4, 8)


def ends_clean(count: int, steps: int) -> bool:
    """Whether a network that always knows the clean sample, all ones, ends with it exactly."""
    schedule = make_schedule(steps)
    schedule.set_timesteps(count)
    values = torch.full((1, 4), 9.0)
    for time in schedule.timesteps:
        values = schedule.step(torch.ones(1, 4), time, values, return_dict=False)[0]
    return len(schedule.timesteps) == count and bool((values - 1.0).abs().max() < 1e-6)


@pytest.mark.parametrize("steps", [1, 7, 50, 100])
def test_counts_are_taken_that_end_without_noise_and_no_others(steps: int) -> None:
    for count in range(1, steps + 3):
        try:
            good = ends_clean(count, steps)
        except ValueError:  # more than there are
            good = False
        if good:
            check_denoising(count, steps)
        else:
            with pytest.raises(InvalidOptionError, match=f"denoising_steps={count} cannot"):
                check_denoising(count, steps)


def test_refusal_names_counts_that_can_be_used() -> None:
    with pytest.raises(InvalidOptionError, match="give one like 19, 20, 23, 24") as refused:
        check_denoising(21, 100)
    for count in str(refused.value).rpartition("like ")[2].split(", "):
        check_denoising(int(count), 100)


@pytest.mark.parametrize("wrong", [{"steps": 10}, {"denoising_steps": 101}, {"denoising_steps": 6}])
def test_a_policy_that_could_not_act_is_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(InvalidOptionError, match="denoising_steps"):
        dataclasses.replace(POLICY, **wrong)


@pytest.mark.parametrize("count", [6, 200])
def test_a_generator_that_could_not_generate_is_refused(count: int) -> None:
    denoiser, latent = Denoiser(DENOISER).eval(), LatentModel(LATENT).eval()
    with pytest.raises(InvalidOptionError, match="denoising_steps"):
        Generator(denoiser, latent, ChainConfig(denoising_steps=count))


@pytest.mark.parametrize("seed", [0.5, 1.0, True, -1, "0", float("nan"), np.float64(2)])
def test_a_seed_is_an_integer(seed: object) -> None:
    with pytest.raises(InvalidOptionError, match="seed="):
        TrainingConfig(steps=1, seed=seed)  # type: ignore[arg-type]


@pytest.mark.parametrize("device", ["meta", "", "nonsense", "cuda:99"])
def test_a_device_without_numbers_is_none(device: str) -> None:
    with pytest.raises(InvalidOptionError, match=f"device='{device}' cannot be used"):
        check_device(device)
    check_device("cpu")
