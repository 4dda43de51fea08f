"""The autoencoder keeps states, and knows how many steps lie between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.stats import spearmanr

from icd_agent.latent import train
from icd_agent.latent.autoencoder import BEGIN, divide
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.latent.pairs import draw_pairs
from icd_agent.latent.reachability import bins_of, expected_steps, shortest_steps
from icd_agent.latent.train import latent_loss, load_latent, train_latent
from icd_agent.training.config import TrainingConfig
from icd_envs.errors import InvalidOptionError
from tests.agent.toy_states import CANONICAL, LATENT, toy_states
from tests.killing import KilledError, kill_at


def test_states_of_other_episodes_come_back(toy_latent: Path) -> None:
    model, states = load_latent(toy_latent), toy_states(10, seed=1)
    features = torch.from_numpy(states.features.astype(np.float32))
    canonical = torch.from_numpy(CANONICAL)
    with torch.no_grad():
        back = model.decode(model.encode(features, canonical), canonical)
    error = (back - features).square().sum(-1).mean()
    spread = (features - features.mean(dim=(0, 1))).square().sum(-1).mean()
    assert float(error / spread) < 0.05


def test_steps_between_states_are_predicted(toy_latent: Path) -> None:
    model, states = load_latent(toy_latent), toy_states(10, seed=1)
    pairs = draw_pairs(states, 300, np.random.default_rng(3))
    canonical = torch.from_numpy(CANONICAL)

    def encode(rows: np.ndarray) -> torch.Tensor:
        return model.encode(torch.from_numpy(states.features[rows].astype(np.float32)), canonical)

    scene = torch.from_numpy(states.seen_from(pairs.first, LATENT.scene_size))
    with torch.no_grad():
        logits = model.reachability(encode(pairs.first), encode(pairs.second), scene)
    found = expected_steps(logits, LATENT).numpy()
    assert np.median(np.abs(found - pairs.gap)) <= LATENT.bin_steps
    assert spearmanr(found, pairs.gap).statistic > 0.9


def saying(mean: float, log_variance: float) -> LatentModel:
    """Says the same of every state, and decodes the first number of a latent as every point's x."""
    model = LatentModel(LATENT)
    with torch.no_grad():
        for value in model.parameters():
            value.zero_()
        model.encoder.out.bias[: LATENT.latent] = mean
        model.encoder.out.bias[LATENT.latent :] = log_variance - BEGIN
    model.components[0, :, 0] = 1.0
    return model


def terms_of(model: LatentModel, features: torch.Tensor) -> dict[str, float]:
    """Of two pairs that are 3 and 205 steps apart, and noise of 3; two points are decoded."""
    scene, gap = torch.zeros(2, 2, 3 + LATENT.scene_features), torch.tensor([3, 205])
    noise, decoded = torch.full((4, LATENT.latent), 3.0), torch.tensor([5, 7])
    found = latent_loss(model, features, torch.from_numpy(CANONICAL), scene, gap, noise, decoded)
    return {name: float(value.detach()) for name, value in found.items()}


@pytest.mark.parametrize(
    ("mean", "log_variance", "kl"),
    [(0.0, 0.0, 0.0), (1.0, 0.0, 8 / 2), (0.0, np.log(4), 8 / 2 * (3 - np.log(4)))],
)
def test_a_latent_costs_by_how_far_it_is_from_a_standard_normal(
    mean: float, log_variance: float, kl: float
) -> None:
    found = terms_of(saying(mean, log_variance), torch.zeros(4, 12, 3))
    assert found["kl"] == pytest.approx(kl, abs=1e-5)


def test_the_terms_of_the_loss_are_those_of_a_drawn_latent_at_the_decoded_points(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(train, "KL_WEIGHT", 10.0)
    monkeypatch.setattr(train, "REACH_WEIGHT", 20.0)
    features = torch.zeros(4, 12, 3)
    features[:, 0, 2], features[:, 5, 2] = 10.0, 2.0  # of these, only the latter is decoded
    found = terms_of(saying(mean=1.0, log_variance=np.log(4)), features)
    drawn = 1.0 + 2.0 * 3.0
    assert found["recon"] == pytest.approx(drawn**2 + 2.0**2 / 2)
    assert found["reach"] == pytest.approx(np.log(LATENT.bins))
    assert found["steps_off"] == pytest.approx((102 + 100) / 2)  # the middle of all bins is 105
    weighted = found["recon"] + 10.0 * found["kl"] + 20.0 * found["reach"]
    assert found["loss"] == pytest.approx(weighted)


def test_a_killed_run_goes_on_to_the_same_weights(tmp_path: Path) -> None:
    config = TrainingConfig(steps=20, save_every=5, log_every=5)
    states = toy_states(5)
    whole = train_latent(states, LATENT, config, tmp_path / "a", about={}).model
    with pytest.raises(KilledError):
        train_latent(states, LATENT, config, tmp_path / "b", about={}, seen=kill_at(10))
    again = train_latent(states, LATENT, config, tmp_path / "b", about={}).model.state_dict()
    assert all(torch.equal(value, again[name]) for name, value in whole.state_dict().items())


def test_parts_cover_the_object() -> None:
    parts = divide(torch.from_numpy(CANONICAL), LATENT)
    assert parts.members.shape == (6, 4)
    assert set(parts.members.flatten().tolist()) == set(range(12))


def test_pairs_are_of_one_episode_and_in_order() -> None:
    states = toy_states()
    pairs = draw_pairs(states, 500, np.random.default_rng(0))
    assert (states.episode[pairs.first] == states.episode[pairs.second]).all()
    assert (pairs.gap == states.step[pairs.second] - states.step[pairs.first]).all()
    assert pairs.gap.min() >= 0
    assert 10 < np.median(pairs.gap) < 60


@pytest.mark.parametrize(
    ("steps", "bin_"), [(0, 0), (9, 0), (10, 1), (199, 19), (200, 20), (999, 20)]
)
def test_bins(steps: int, bin_: int) -> None:
    assert bins_of(torch.tensor(steps), LATENT) == bin_


def test_a_certain_distance_is_its_own_soft_minimum_and_doubt_draws_it_down() -> None:
    certain = torch.full((1, LATENT.bins), -50.0)
    certain[0, 4] = 50.0
    assert float(expected_steps(certain, LATENT)) == pytest.approx(45.0)
    assert float(shortest_steps(certain, LATENT)) == pytest.approx(45.0)
    doubt = torch.full((1, LATENT.bins), -50.0)
    doubt[0, [4, 14]] = 0.0
    assert float(expected_steps(doubt, LATENT)) == pytest.approx(95.0)
    # -s log(0.5 exp(-45 / s) + 0.5 exp(-145 / s)) with s = 10
    assert float(shortest_steps(doubt, LATENT)) == pytest.approx(45.0 + 10.0 * np.log(2), abs=1e-2)


@pytest.mark.parametrize("wrong", [{"latent": 0}, {"softness": 0.0}, {"bins": 2.5}])
def test_wrong_sizes_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        LatentConfig(**{"features": 3, "scene_features": 4, "points": 12, **wrong})
