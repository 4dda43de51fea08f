"""What is floor and what stands on it, in exact and in noisy clouds."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from icd_agent.field.encoder import find_fixtures
from tests.envs.making import make

MARGIN = 0.003
TASKS = ("ICDCableRouting-v0", "ICDNotebookFolding-v0")


@pytest.fixture(scope="module", params=TASKS)
def scene(request: pytest.FixtureRequest) -> Tensor:
    env = make(request.param)
    return torch.from_numpy(env.reset(seed=3)[0]["scene"])[None]


def test_in_an_exact_cloud_the_lowest_point_is_the_floor(scene: Tensor) -> None:
    floor, fixture = find_fixtures(scene, MARGIN)
    height = scene[..., 2]
    assert floor == height.min()
    assert torch.equal(fixture, height > floor + MARGIN)


@pytest.mark.parametrize("noise", [0.001, 0.002, 0.005])
def test_noise_makes_no_fixtures_of_the_floor(scene: Tensor, noise: float) -> None:
    rng = np.random.default_rng(0)
    noisy = scene + torch.from_numpy(rng.normal(0.0, noise, scene.shape).astype(np.float32))
    floor, fixture = find_fixtures(noisy, MARGIN)
    ground = scene[..., 2] == scene[..., 2].min()
    assert abs(floor - scene[..., 2].min()) < 0.003
    assert (fixture & ground).sum() < 0.05 * ground.sum()
    assert (fixture & ~ground).sum() > 0.6 * (~ground).sum()


def test_a_few_low_points_of_what_stands_there_are_no_noise() -> None:
    rising = torch.zeros(1, 1000, 3)
    rising[0, :, 2] = torch.linspace(0.0, 0.5, 1000)
    floor, fixture = find_fixtures(rising, MARGIN)
    assert floor == 0.0
    assert torch.equal(fixture, rising[..., 2] > MARGIN)


def test_a_bare_floor_is_all_there_is_to_hold_on_to() -> None:
    flat = torch.rand(1, 100, 3) * torch.tensor([1.0, 1.0, 0.0])
    assert find_fixtures(flat, MARGIN)[1].all()
