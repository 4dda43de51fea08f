"""Training SAC when something is wrong: typed errors, and no scene met twice because of a kill."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import pytest
import torch

from benchmarks import train_sac
from icd_agent.checkpoints import read_about
from icd_envs.errors import InvalidOptionError, TrainingError
from tests.baselines.test_sac_her import TINY
from tests.bench.making import icd_bench
from tests.envs.making import CABLE


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(train_sac, "CONFIG", TINY)


def train(out: Path, steps: int, seed: int = 0) -> None:
    train_sac.train(CABLE, out, device="cpu", steps=steps, seed=seed)


def test_fewer_steps_than_were_done_are_refused_and_nothing_is_saved_as_them(
    tmp_path: Path,
) -> None:
    train(tmp_path, 20)
    before = (tmp_path / "config.json").read_bytes()
    with pytest.raises(TrainingError, match="has 20 steps, more than the 8 wanted: give --steps 2"):
        train(tmp_path, 8)
    assert (tmp_path / "config.json").read_bytes() == before
    assert read_about(tmp_path)["training"]["steps"] == 20


def test_steps_that_were_done_are_told_not_those_that_were_wanted(tmp_path: Path) -> None:
    for _ in range(2):  # a finished run is not trained further
        train(tmp_path, 10)
        assert read_about(tmp_path)["training"]["steps"] == 12  # gradients every four steps


def test_every_beginning_has_scenes_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seeds: list[int] = []
    seed_all = train_sac.SAC.set_random_seed

    def told(model: Any, seed: int) -> None:  # noqa: ANN401  of Stable-Baselines3
        seeds.append(seed)
        seed_all(model, seed)

    monkeypatch.setattr(train_sac.SAC, "set_random_seed", told)
    used = []
    for name, steps in (("a", 8), ("a", 16), ("a", 24), ("b", 8), ("b", 16)):
        train(tmp_path / name, steps)
        used.append(seeds[-1])
    assert used[0] == used[3] == 0  # what is not interrupted is as it was
    assert used[1] == used[4]  # and the same kill gives the same run
    assert len({*used[:3]}) == 3


def test_a_misspelt_environment_is_answered_before_a_folder_is_made(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(InvalidOptionError, match="did you mean"):
        train_sac.train("ICDCableRoutin-v0", out, device="cpu", steps=8, seed=0)
    refused = icd_bench("train", "sac-her", "--env", "ICDCableRoutin-v0", "--out", out)
    assert refused.exit_code == 2
    assert len(refused.stderr.strip().splitlines()) == 1
    assert not out.exists()


def test_a_full_disk_is_an_error_of_one_line_and_the_environment_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train(tmp_path, 8)
    before = (tmp_path / train_sac.STATE_NAME).read_bytes()
    closed: list[bool] = []
    close = train_sac.SubsamplePointCloud.close

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    def counted(env: Any) -> None:  # noqa: ANN401  any environment
        closed.append(True)
        close(env)

    monkeypatch.setattr(train_sac.SubsamplePointCloud, "close", counted)
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(TrainingError, match=r"cannot write .*training.pt.*free some space"):
        train(tmp_path, 16)
    assert closed
    assert (tmp_path / train_sac.STATE_NAME).read_bytes() == before
    assert not list(tmp_path.glob("*.new"))


def test_weights_that_are_not_finite_are_not_saved(tmp_path: Path) -> None:
    train(tmp_path, 8)
    path = tmp_path / train_sac.STATE_NAME
    state = torch.load(path, weights_only=True)
    state["parameters"]["policy"]["critic.qf0.0.bias"].fill_(float("nan"))
    content = io.BytesIO()
    torch.save(state, content)
    path.write_bytes(content.getvalue())
    with pytest.raises(TrainingError, match=r"critic.qf0.0.bias is not finite after 16 steps"):
        train(tmp_path, 16)
    assert path.read_bytes() == content.getvalue()


def test_a_state_of_another_shape_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train(tmp_path, 8)
    wider = train_sac.ActorConfig(8, 8, (8, 16), (24,))
    monkeypatch.setattr(train_sac, "CONFIG", wider)
    with pytest.raises(TrainingError, match="does not fit the model"):
        train(tmp_path, 16)
