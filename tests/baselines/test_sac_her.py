"""SAC with hindsight: our actor is Stable-Baselines3's, and its training goes on after a kill."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

from baselines.sac_her import ActorAgent, ActorConfig, load_actor, make_sac_her
from benchmarks import train_sac
from icd_agent.checkpoints import read_about
from icd_agent.weights import SAC_HER, shipped_folder
from icd_envs.api import Agent
from icd_envs.errors import CheckpointError, InvalidOptionError, TrainingError
from icd_envs.wrappers import SubsamplePointCloud
from tests.bench.making import icd_bench
from tests.envs.making import CABLE
from tests.pickles import MakesFolder

STEPS = 640
LEARNING_STARTS = 308
"""Control steps: more than an episode has, which hindsight needs one of."""
TINY = ActorConfig(object_points=8, scene_points=8, point_widths=(8, 16), widths=(16,))


@pytest.fixture
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(train_sac, "CONFIG", TINY)
    monkeypatch.setattr(train_sac, "SAVE_EVERY", STEPS // 2)


def test_the_actor_acts_as_the_model_it_is_taken_from(tiny: None, tmp_path: Path) -> None:
    env = SubsamplePointCloud(gym.make(CABLE), TINY.object_points, TINY.scene_points)
    model = train_sac._make(env, 10, "cpu", seed=0)
    with torch.no_grad():
        for value in model.actor.parameters():
            value += 0.1 * torch.randn(value.shape, generator=torch.Generator().manual_seed(0))
    observation, _ = env.reset(seed=0)
    agent = ActorAgent(train_sac.actor_of(model))
    assert isinstance(agent, Agent)
    whole: Any = env.unwrapped
    agent.reset(whole.episode(), seed=0)
    for _ in range(3):
        action = agent.act(whole.restore(whole.snapshot()))
        expected, _ = model.predict(observation, deterministic=True)
        np.testing.assert_allclose(action, expected, atol=1e-6)
        assert np.abs(action).max() > 1e-3
        observation, *_ = env.step(env.action_space.sample())
    env.close()


def test_training_leaves_an_actor_and_a_longer_one_learns_on_from_it(
    tiny: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = train_sac._make
    monkeypatch.setattr(train_sac, "_make", lambda env, _, *rest: make(env, LEARNING_STARTS, *rest))
    command = ("train", "sac-her", "--env", CABLE, "--out", tmp_path, "--json")
    actors, updates = [], []
    for steps in (STEPS // 2, STEPS):
        trained = icd_bench(*command, "--steps", steps)
        assert trained.exit_code == 0, trained.stderr
        assert json.loads(trained.stdout)["steps"] == steps
        state = torch.load(tmp_path / train_sac.STATE_NAME, weights_only=True)
        assert state["step"] == steps
        assert read_about(tmp_path)["training"]["gradient_steps"] == state["updates"]
        actors.append(load_actor(tmp_path))
        updates.append(state["updates"])
    # Each run begins with actions that are random, and with an empty buffer.
    assert updates == [n * (STEPS // 2 - LEARNING_STARTS) // train_sac.TRAIN_EVERY for n in (1, 2)]
    assert actors[0].config == actors[1].config == TINY
    before, after = (actor.state_dict() for actor in actors)
    assert before.keys() == after.keys()
    assert all(not torch.equal(before[name], after[name]) for name in before)


def test_another_runs_state_is_refused(tiny: None, tmp_path: Path) -> None:
    command = ("train", "sac-her", "--env", CABLE, "--out", tmp_path, "--steps", 10)
    assert icd_bench(*command).exit_code == 0
    refused = icd_bench(*command, "--seed", 1)
    assert refused.exit_code == 2
    assert "choose another --out" in refused.stderr
    (tmp_path / train_sac.STATE_NAME).write_bytes(b"nothing")
    with pytest.raises(TrainingError, match="damaged"):
        train_sac.train(CABLE, tmp_path, device="cpu", steps=20, seed=0)


def test_a_pickle_in_the_state_is_never_executed(tiny: None, tmp_path: Path) -> None:
    torch.save(MakesFolder(tmp_path / "executed"), tmp_path / train_sac.STATE_NAME)
    with pytest.raises(TrainingError, match="damaged"):
        train_sac.train(CABLE, tmp_path, device="cpu", steps=20, seed=0)
    assert not (tmp_path / "executed").exists()


def test_what_it_learns_is_used_when_it_goes_on(tiny: None, tmp_path: Path) -> None:
    train_sac.train(CABLE, tmp_path, device="cpu", steps=10, seed=0)
    path = tmp_path / train_sac.STATE_NAME
    state = torch.load(path, weights_only=True)
    for name, value in state["parameters"]["policy"].items():
        if name.startswith("actor.mu"):
            value.fill_(0.25)
    torch.save(state, path)
    train_sac.train(CABLE, tmp_path, device="cpu", steps=10, seed=0)
    assert torch.equal(load_actor(tmp_path).mean.bias.data, torch.full((3,), 0.25))


@pytest.mark.parametrize("wrong", [{"object_points": 0}, {"widths": ()}, {"point_widths": (0,)}])
def test_wrong_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        dataclasses.replace(TINY, **wrong)


def test_an_actor_of_another_task_is_refused() -> None:
    with pytest.raises(CheckpointError, match="ICDNotebookFolding-v0 cannot be used in"):
        make_sac_her(CABLE, shipped_folder("ICDNotebookFolding-v0", SAC_HER))


def test_missing_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=str(tmp_path)):
        load_actor(tmp_path)
