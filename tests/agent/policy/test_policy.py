"""Policies: laws of their parts, and a toy whose right actions are known."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from icd_agent.policy.config import PolicyConfig, Prediction
from icd_agent.policy.data import PolicyData, Windows
from icd_agent.policy.encoders import KeyPointEncoder, PointEncoder, Seen
from icd_agent.policy.look import Look, evenly
from icd_agent.policy.policy import ChunkPolicy, load_policy
from icd_agent.policy.train import policy_loss, train_policy
from icd_agent.policy.unet import ConditionalUNet
from icd_agent.training.config import TrainingConfig
from icd_agent.training.initial import initialise
from icd_envs.errors import CheckpointError, InvalidOptionError
from tests.agent.field.small import SMALL, scene, small_field
from tests.agent.policy.toy import POINTS, toy_demonstrations
from tests.killing import KilledError, kill_at

KEY_POINTS = dataclasses.replace(POINTS, sees="key points", scene_features=SMALL.descriptor)


def random_seen(config: PolicyConfig, count: int = 2) -> Seen:
    draw = torch.Generator().manual_seed(0)

    def some(*shape: int) -> torch.Tensor:
        return torch.rand(count, *shape, generator=draw) - 0.5

    observed, points = config.observed, config.object_points
    scene = config.scene_points, 3 + config.scene_features
    return Seen(
        some(observed, 3), some(observed, points, 3), some(points, 3), some(*scene), some(*scene)
    )


def made(module: torch.nn.Module) -> Any:  # noqa: ANN401  any module
    initialise(module, torch.Generator().manual_seed(0))
    return module.eval()


@pytest.mark.parametrize(
    ("config", "encoder"), [(POINTS, PointEncoder), (KEY_POINTS, KeyPointEncoder)]
)
def test_the_order_of_a_scenes_points_means_nothing_and_all_else_something(
    config: PolicyConfig, encoder: type
) -> None:
    network, seen = made(encoder(config)), random_seen(config)
    with torch.no_grad():
        before = network(seen)
        assert before.shape == (2, network.size)
        shuffled = seen._replace(scene=seen.scene.flip(1), goal_scene=seen.goal_scene.flip(1))
        torch.testing.assert_close(network(shuffled), before)
        for name in Seen._fields:
            moved = seen._replace(**{name: getattr(seen, name) + 0.3})
            assert not torch.allclose(network(moved), before, atol=1e-4), name
        # Whose point it is matters, not only where it is.
        swapped = seen._replace(scene=seen.goal_scene, goal_scene=seen.scene)
        assert not torch.allclose(network(swapped), before, atol=1e-4)


@pytest.mark.parametrize("widths", [(16,), (16, 32), (8, 16, 24)])
def test_the_u_net_hears_everything_and_keeps_the_shape(widths: tuple[int, ...]) -> None:
    config = dataclasses.replace(POINTS, widths=widths)
    network = made(ConditionalUNet(config, 3, 5))
    draw = torch.Generator().manual_seed(1)
    noisy, condition = (torch.randn(2, *size, generator=draw) for size in ((8, 3), (5,)))
    time = torch.tensor([3, 50])
    with torch.no_grad():
        before = network(noisy, time, condition)
        assert before.shape == noisy.shape
        assert not torch.allclose(network(noisy, time + 1, condition), before)
        assert not torch.allclose(network(noisy, time, condition + 1), before)
        last = noisy.clone()
        last[:, -1] += 1.0
        changed = (network(last, time, condition) != before).any(dim=2)
        assert changed.all()  # the first action hears of the last one
        one = network(noisy[:1], time[:1], condition[:1])
        torch.testing.assert_close(one, before[:1], atol=1e-5, rtol=1e-5)


def test_what_is_learned_leads_to_the_goal(tmp_path: Path) -> None:
    config, field = dataclasses.replace(KEY_POINTS, prediction="sample"), small_field()
    recorded = toy_demonstrations(40)
    data = PolicyData(recorded, Look(config, field), config, episodes=40, solved_only=False)
    training = TrainingConfig(steps=200, learning_rate=3e-3, warmup=20, ema=0.98)
    train_policy(data, config, training, tmp_path, about={})
    rng = np.random.default_rng(0)
    seen, actions = data.draw(128, rng)
    found = load_policy(tmp_path).sample(seen, rng)
    assert np.abs(found).max() <= 1.0
    own = (seen.scene == seen.goal_scene).flatten(1).all(dim=1)  # elsewhere goals are anything
    ahead = (seen.goal[:, 0] - seen.gripper[:, 1])[own].numpy()
    error = np.abs(found - actions.numpy())[own.numpy()]
    assert error.mean() < 0.65 * np.abs(actions.numpy()[own.numpy()]).mean()
    far = np.abs(ahead).max(axis=1) > 0.1
    along = np.abs(ahead[far]).argmax(axis=1)
    taken = found[own.numpy()][far, 1][np.arange(far.sum()), along]
    assert (np.sign(taken) == np.sign(ahead[far][np.arange(far.sum()), along])).mean() > 0.8


class Knowing(ChunkPolicy):
    """Knows the clean actions, and answers as it is asked."""

    def __init__(self, config: PolicyConfig, clean: torch.Tensor) -> None:
        super().__init__(config, (-torch.ones(3), torch.ones(3)))
        self.clean = clean

    def forward(
        self, noisy: torch.Tensor, time: torch.Tensor, condition: torch.Tensor
    ) -> torch.Tensor:
        if self.config.prediction == "sample":
            return self.clean
        left = self.schedule().alphas_cumprod[time][:, None, None]
        return (noisy - left.sqrt() * self.clean) / (1.0 - left).sqrt()


@pytest.mark.parametrize("prediction", ["epsilon", "sample"])
@pytest.mark.parametrize("eta", [0.0, 1.0])
def test_with_the_right_predictions_the_right_actions_are_sampled(
    prediction: Prediction, eta: float
) -> None:
    config = dataclasses.replace(POINTS, prediction=prediction, eta=eta)
    clean = torch.rand(2, 8, 3, generator=torch.Generator().manual_seed(2)) * 1.8 - 0.9
    found = Knowing(config, clean).sample(random_seen(config), np.random.default_rng(0))
    np.testing.assert_allclose(found, clean.numpy(), atol=1e-3)


@pytest.mark.parametrize("prediction", ["epsilon", "sample"])
def test_with_the_right_predictions_there_is_no_loss(prediction: Prediction) -> None:
    config = dataclasses.replace(POINTS, prediction=prediction)
    clean = torch.rand(2, 8, 3, generator=torch.Generator().manual_seed(2)) * 1.8 - 0.9
    windows = Windows(random_seen(config), clean)
    noise, time = (
        torch.randn(2, 8, 3, generator=torch.Generator().manual_seed(3)),
        torch.tensor([5, 60]),
    )
    policy = Knowing(config, clean)
    assert float(policy_loss(policy, policy.schedule(), windows, noise, time)["loss"]) < 1e-6
    off = Knowing(config, clean + 0.1)
    assert float(policy_loss(off, policy.schedule(), windows, noise, time)["loss"]) > 1e-3


def test_a_sample_follows_from_its_generator_only() -> None:
    policy = made(ChunkPolicy(POINTS, (-torch.ones(3), torch.ones(3))))
    seen = random_seen(POINTS)
    first, again, other = (policy.sample(seen, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first.shape == (2, POINTS.horizon, 3)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_low_temperature_keeps_to_what_is_likely() -> None:
    def spread(temperature: float) -> float:
        config = dataclasses.replace(POINTS, prediction="sample", eta=0.0, temperature=temperature)
        policy = made(ChunkPolicy(config, (-torch.ones(3), torch.ones(3))))
        seen = random_seen(config)
        found = [policy.sample(seen, np.random.default_rng(seed)) for seed in range(8)]
        return float(np.ptp(found, axis=0).mean())

    assert spread(0.0) == 0.0
    assert 0.0 < spread(0.5) < spread(1.0)


def test_places_enter_between_the_limits() -> None:
    limits = torch.tensor([-1.0, 0.0, 2.0]), torch.tensor([1.0, 4.0, 3.0])
    policy = ChunkPolicy(POINTS, limits)
    torch.testing.assert_close(
        policy._normalise(torch.stack(limits)), torch.tensor([[-1.0], [1.0]]).expand(2, 3)
    )


def test_a_killed_run_goes_on_to_the_same_weights(tmp_path: Path) -> None:
    recorded = toy_demonstrations()
    data = PolicyData(recorded, Look(POINTS, None), POINTS, episodes=6, solved_only=False)
    config = TrainingConfig(steps=20, save_every=5, log_every=5)
    train_policy(data, POINTS, config, tmp_path / "a", about={})
    with pytest.raises(KilledError):
        train_policy(data, POINTS, config, tmp_path / "b", about={}, seen=kill_at(10))
    train_policy(data, POINTS, config, tmp_path / "b", about={})
    whole, again = (load_policy(tmp_path / name).state_dict() for name in "ab")
    assert all(torch.equal(value, again[name]) for name, value in whole.items())


def test_a_look_thins_clouds_and_tells_fixtures_from_the_floor() -> None:
    cloud = scene(0).cloud
    points = Look(POINTS, None).scene(cloud)
    assert points.shape == (POINTS.scene_points, 3)
    assert (points[:, 2] > 0.003).all()
    assert np.isin(points, cloud).all()
    tokens = Look(KEY_POINTS, small_field()).scene(cloud)
    assert tokens.shape == (POINTS.scene_points, 3 + SMALL.descriptor)
    bar = np.arange(15.0).reshape(5, 3)
    np.testing.assert_array_equal(Look(POINTS, None).object(bar), bar[[0, 1, 3, 4]])
    np.testing.assert_array_equal(evenly(200, 2), [0, 199])


def test_a_policy_and_a_field_that_do_not_fit_are_refused() -> None:
    for config, field in ((POINTS, small_field()), (KEY_POINTS, None)):
        with pytest.raises(CheckpointError, match="scene features"):
            Look(config, field)


@pytest.mark.parametrize(
    "wrong",
    [
        {"sees": "nothing"},
        {"prediction": "velocity"},
        {"horizon": 9},
        {"executed": 8},
        {"widths": (10,)},
        {"kernel": 4},
        {"time_width": 7},
        {"scene_features": 3},
        {"observed": 0},
    ],
)
def test_wrong_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        dataclasses.replace(POINTS, **wrong)
