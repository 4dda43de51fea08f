"""Layers turn with their input, and a channel along gravity leaves the turns about it."""

from __future__ import annotations

import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor, nn

from icd_agent.field.vector_neurons import Invariants, VectorLeakyReLU, VectorLinear, upward

CHANNELS = 5


def rotation(seed: int) -> Tensor:
    return torch.from_numpy(Rotation.random(random_state=seed).as_matrix())


def turn(vectors: Tensor, matrix: Tensor) -> Tensor:
    return torch.einsum("ij,...jc->...ic", matrix, vectors)


@pytest.fixture
def vectors() -> Tensor:
    return torch.randn(4, 6, 3, CHANNELS, dtype=torch.float64, generator=torch.manual_seed(0))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("layer", [VectorLinear(CHANNELS, 7), VectorLeakyReLU(CHANNELS)])
def test_layers_turn_with_their_input(layer: nn.Module, vectors: Tensor, seed: int) -> None:
    layer, matrix = layer.double(), rotation(seed)
    torch.testing.assert_close(layer(turn(vectors, matrix)), turn(layer(vectors), matrix))


@pytest.mark.parametrize("seed", range(5))
def test_invariants_stay(vectors: Tensor, seed: int) -> None:
    layer = Invariants(CHANNELS).double()
    assert layer(vectors).shape == (4, 6, 3 * CHANNELS)
    torch.testing.assert_close(layer(turn(vectors, rotation(seed))), layer(vectors))


def test_activation_only_shortens_what_points_against_its_direction(vectors: Tensor) -> None:
    layer = VectorLeakyReLU(CHANNELS, slope=0.0).double()
    directions = layer.directions(vectors)
    before, after = ((v * directions).sum(-2) for v in (vectors, layer(vectors)))
    along = before > 0
    assert along.any()
    assert (~along).any()
    torch.testing.assert_close(after[along], before[along])
    torch.testing.assert_close(after[~along], torch.zeros_like(after[~along]), atol=1e-5, rtol=0)


def test_upward_is_fixed_by_turns_about_gravity_only(vectors: Tensor) -> None:
    up = upward(vectors)
    assert up.shape == (4, 6, 3, 1)
    yaw, roll = (
        torch.from_numpy(Rotation.from_euler(axis, 1.0).as_matrix()) for axis in ("z", "x")
    )
    torch.testing.assert_close(turn(up, yaw), up)
    assert (turn(up, roll) - up).abs().max() > 0.5
