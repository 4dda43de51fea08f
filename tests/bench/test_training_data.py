"""What a training knows of its data: other data are refused, and so are test scenes."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import train_field
from benchmarks.described import about_of, describe_places, read_demonstrations
from benchmarks.train_policy import train as train_policy
from benchmarks.training_order import TrainingOrder
from icd_agent.checkpoints import read_about
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError, TrainingError
from tests.demonstrations.making import STEPS, make_folder
from tests.envs.making import CABLE


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_folder(tmp_path_factory.mktemp("data") / "cable", episodes=2)


@pytest.fixture(scope="module")
def unseen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_folder(tmp_path_factory.mktemp("data") / "cable", episodes=2, split="test")


def order(data: Path, out: Path) -> TrainingOrder:
    return TrainingOrder(CABLE, data, out, "cpu", steps=1, episodes=2, seed=0)


def train(name: str, order: TrainingOrder) -> None:
    if name == "dp3":
        train_policy("dp3", order, solved_only=False, field=None)
        return
    scales = train_field.Scales(anchors=16, steps=order.steps)
    train_field.train(
        order.env_id,
        order.data,
        order.out,
        "local",
        scales,
        device="cpu",
        scenes=order.episodes,
        seed=order.seed,
        split=order.split,
    )


def test_data_are_told_by_split_noise_budget_and_content(data: Path, tmp_path: Path) -> None:
    about = about_of(Demonstrations(data), 2)
    assert json.loads(json.dumps(about)) == about
    assert (about["split"], about["noisy"], about["most_steps"]) == ("train", True, STEPS)
    other = about_of(Demonstrations(make_folder(tmp_path / "clean", episodes=2, noisy=False)), 2)
    assert {name for name in about if about[name] != other[name]} == {"noisy", "sha256"}


def test_episodes_that_are_collected_later_do_not_change_what_was_learned_from(
    data: Path, tmp_path: Path
) -> None:
    more = make_folder(tmp_path / "more", episodes=4)
    first, later = (Demonstrations(folder) for folder in (data, more))
    assert about_of(later, 2) == about_of(first, 100)
    assert about_of(later, 3)["sha256"] != about_of(later, 2)["sha256"]


@pytest.mark.parametrize("name", ["field", "dp3"])
def test_training_on_test_scenes_is_refused_unless_they_are_meant(
    unseen: Path, tmp_path: Path, name: str
) -> None:
    refused = order(unseen, tmp_path / "out")
    with pytest.raises(DemonstrationsError, match="split='test', expected 'train'"):
        train(name, refused)
    assert not refused.out.exists()
    train(name, replace(refused, split="test"))
    assert read_about(refused.out)["data"]["split"] == "test"


def test_states_of_test_scenes_are_described_only_where_they_are_meant(unseen: Path) -> None:
    with pytest.raises(DemonstrationsError, match="split='test'"):
        describe_places(CABLE, unseen, None, 2)
    assert len(read_demonstrations(CABLE, unseen, "test")) == 2


@pytest.mark.parametrize("name", ["field", "dp3"])
def test_data_that_were_recorded_anew_are_another_run(
    data: Path, tmp_path: Path, name: str
) -> None:
    out = tmp_path / "out"
    train(name, order(data, out))
    anew = shutil.copytree(data, tmp_path / "anew")
    train(name, order(anew, out))  # the same episodes elsewhere
    shutil.rmtree(anew)
    make_folder(anew, episodes=2, noisy=False)
    with pytest.raises(TrainingError, match=r"data.noisy \(true there, false now\), data.sha256"):
        train(name, order(anew, out))
