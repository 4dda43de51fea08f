"""Principal components: laws, and states that lie in a plane."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from icd_agent.latent.model import LatentModel
from icd_agent.latent.principal import Principal, principal
from icd_envs.errors import InvalidOptionError
from tests.agent.toy_states import CANONICAL, LATENT, toy_states


def of_random_states(latent: int, count: int) -> tuple[Principal, np.ndarray]:
    features = np.random.default_rng(0).normal(size=(60, 5, 3)).astype(np.float16)
    features *= np.linspace(1.0, 3.0, 5, dtype=np.float16)[:, None]
    found = principal(features[:count].astype(np.float32), latent)
    normal = (features.astype(np.float32) - found.mean) / found.scale
    return found, normal


@pytest.mark.parametrize("count", [4, 10, 60])  # fewer than components, than numbers, and more
def test_components_are_orthogonal_and_of_one_length(count: int) -> None:
    found, _ = of_random_states(6, count)
    flat = found.components.reshape(6, -1)
    np.testing.assert_allclose(flat @ flat.T, 5 / 6 * np.eye(6), atol=1e-5)


def test_the_first_explain_most_and_coefficients_are_about_one() -> None:
    found, normal = of_random_states(6, 60)
    flat = found.components.reshape(6, -1)
    coefficients = 6 / 5 * normal.reshape(60, -1) @ flat.T
    spread = coefficients.var(axis=0)
    assert (np.diff(spread) <= 1e-5).all()
    left = np.square(normal.reshape(60, -1) - coefficients @ flat).sum(-1) / 5
    assert left.mean() + np.square(coefficients).mean() == pytest.approx(1.0, rel=1e-3)
    # No other plane of six dimensions leaves less: that is what they are.
    values = np.linalg.eigvalsh(np.cov(normal.reshape(60, -1).T, bias=True))
    assert left.mean() == pytest.approx(values[:-6].sum() / 5, rel=1e-3)


def test_normalised_features_have_unit_size() -> None:
    _, normal = of_random_states(6, 60)
    assert np.square(normal).sum(-1).mean() == pytest.approx(1.0, rel=1e-4)


def test_states_in_a_plane_come_back_before_any_training() -> None:
    states = toy_states()  # a bar that moves in a plane: two numbers say where it is
    model = LatentModel(LATENT, principal(states.features.astype(np.float32), 8)).eval()
    for part in (model.encoder.out, model.decoder.layers[-1]):
        for value in part.parameters():
            value.data.zero_()
    features = torch.from_numpy(states.features.astype(np.float32))
    canonical = torch.from_numpy(CANONICAL)
    with torch.no_grad():
        back = model.decode(model.encode(features, canonical), canonical)
    assert float((back - features).abs().max()) < 1e-3


def test_more_components_than_numbers_are_refused() -> None:
    with pytest.raises(InvalidOptionError, match="latent"):
        of_random_states(16, 60)


def test_another_number_of_points_is_refused() -> None:
    model = LatentModel(LATENT).eval()
    with pytest.raises(InvalidOptionError, match="points"):
        model.encode(torch.zeros(1, 11, 3), torch.zeros(11, 3))
