"""The autoencoder keeps states, and knows how many steps lie between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.stats import spearmanr

from icd_agent.latent.autoencoder import divide
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.pairs import draw_pairs
from icd_agent.latent.reachability import bins_of, expected_steps, shortest_steps
from icd_agent.latent.train import load_latent, train_latent
from icd_agent.training.config import TrainingConfig
from icd_envs.errors import InvalidOptionError
from tests.agent.toy_states import CANONICAL, toy_states

SMALL = LatentConfig(3, 4, 12, latent=8, groups=6, neighbours=4, width=16, decoder_width=16)
TRAINING = TrainingConfig(steps=500, learning_rate=5e-3, warmup=20, log_every=50, ema=0.98)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("latent")
    train_latent(toy_states(), SMALL, TRAINING, out, about={})
    return out


def test_states_of_other_episodes_come_back(trained: Path) -> None:
    model, states = load_latent(trained), toy_states(10, seed=1)
    features = torch.from_numpy(states.features.astype(np.float32))
    canonical = torch.from_numpy(CANONICAL)
    with torch.no_grad():
        back = model.decode(model.encode(features, canonical), canonical)
    error = (back - features).square().sum(-1).mean()
    spread = (features - features.mean(dim=(0, 1))).square().sum(-1).mean()
    assert float(error / spread) < 0.05


def test_steps_between_states_are_predicted(trained: Path) -> None:
    model, states = load_latent(trained), toy_states(10, seed=1)
    pairs = draw_pairs(states, 300, np.random.default_rng(3))
    canonical = torch.from_numpy(CANONICAL)

    def encode(rows: np.ndarray) -> torch.Tensor:
        return model.encode(torch.from_numpy(states.features[rows].astype(np.float32)), canonical)

    scene = torch.from_numpy(states.seen_from(pairs.first, SMALL.scene_size))
    with torch.no_grad():
        logits = model.reachability(encode(pairs.first), encode(pairs.second), scene)
    found = expected_steps(logits, SMALL).numpy()
    assert np.median(np.abs(found - pairs.gap)) <= SMALL.bin_steps
    assert spearmanr(found, pairs.gap).statistic > 0.9


def test_a_killed_run_goes_on_to_the_same_weights(tmp_path: Path) -> None:
    class KilledError(Exception):
        pass

    def stop(step: int, terms: dict[str, float]) -> None:
        if step == 10:
            raise KilledError

    config = TrainingConfig(steps=20, save_every=5, log_every=5)
    states = toy_states(5)
    whole = train_latent(states, SMALL, config, tmp_path / "a", about={}).model
    with pytest.raises(KilledError):
        train_latent(states, SMALL, config, tmp_path / "b", about={}, seen=stop)
    again = train_latent(states, SMALL, config, tmp_path / "b", about={}).model.state_dict()
    assert all(torch.equal(value, again[name]) for name, value in whole.state_dict().items())


def test_parts_cover_the_object() -> None:
    parts = divide(torch.from_numpy(CANONICAL), SMALL)
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
    assert bins_of(torch.tensor(steps), SMALL) == bin_


def test_a_certain_distance_is_its_own_soft_minimum_and_doubt_draws_it_down() -> None:
    certain = torch.full((1, SMALL.bins), -50.0)
    certain[0, 4] = 50.0
    assert float(expected_steps(certain, SMALL)) == pytest.approx(45.0)
    assert float(shortest_steps(certain, SMALL)) == pytest.approx(45.0)
    doubt = torch.full((1, SMALL.bins), -50.0)
    doubt[0, [4, 14]] = 0.0
    assert float(expected_steps(doubt, SMALL)) == pytest.approx(95.0)
    # -s log(0.5 exp(-45 / s) + 0.5 exp(-145 / s)) with s = 10
    assert float(shortest_steps(doubt, SMALL)) == pytest.approx(45.0 + 10.0 * np.log(2), abs=1e-2)


@pytest.mark.parametrize("wrong", [{"latent": 0}, {"softness": 0.0}, {"bins": 2.5}])
def test_wrong_sizes_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        LatentConfig(**{"features": 3, "scene_features": 4, "points": 12, **wrong})
