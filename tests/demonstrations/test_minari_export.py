"""Minari loads what we export, and its own collector takes our environments."""

from __future__ import annotations

import builtins
from pathlib import Path

import gymnasium as gym
import minari
import numpy as np
import pytest

import icd_envs
from icd_envs.demonstrations import Demonstrations
from icd_envs.demonstrations.minari_export import check_dataset_id, export
from icd_envs.errors import DemonstrationsError, InvalidOptionError
from tests.demonstrations.making import make_folder

ID = "icd/cable-routing/noisy-v0"


@pytest.fixture(autouse=True)
def root(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where Minari keeps its datasets."""
    root = tmp_path_factory.mktemp("minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(root))
    return root


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two short episodes."""
    return make_folder(tmp_path_factory.mktemp("demonstrations"), episodes=2)


def assert_repeats(dataset: minari.MinariDataset) -> None:
    env = dataset.recover_environment()
    for episode in dataset.iterate_episodes():
        seed = next(iter(dataset.storage.get_episode_metadata([episode.id])))["seed"]
        observations = [env.reset(seed=seed)[0]]
        rewards = []
        for action in episode.actions:
            observation, reward, *_ = env.step(action)
            observations.append(observation)
            rewards.append(reward)
        np.testing.assert_array_equal(episode.rewards, rewards)
        assert set(episode.observations) == set(observations[0])
        for name, recorded in episode.observations.items():
            assert recorded.dtype == np.float32
            np.testing.assert_array_equal(recorded, np.stack([o[name] for o in observations]))
    env.close()


def test_loaded_dataset_replays_to_the_same_bits(folder: Path, root: Path) -> None:
    demonstrations = Demonstrations(folder)
    exported = export(demonstrations, ID)
    assert exported.episodes + exported.left_out == 2
    dataset = minari.load_dataset(ID)
    assert dataset.total_episodes == exported.episodes >= 1
    assert dataset.observation_space == gym.make("ICDCableRouting-v0").observation_space
    assert_repeats(dataset)
    first = dataset[0]
    np.testing.assert_array_equal(first.actions, demonstrations.episode(0).actions)
    assert first.truncations.tolist() == [False] * (len(first.actions) - 1) + [True]
    assert not first.terminations.any()
    assert set(first.infos) == {"is_success", "complete_rate"}
    assert ID in minari.list_local_datasets()
    assert not list(root.rglob(".unfinished-*"))


def test_episode_in_a_scene_that_reset_skips_is_left_out(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    demonstrations = Demonstrations(folder)
    demonstrations._parameters["clips"][0] += 1.0
    exported = export(demonstrations, ID)
    assert exported.left_out >= 1
    (episode,) = minari.load_dataset(ID)
    np.testing.assert_array_equal(episode.actions, demonstrations.episode(1).actions)


def test_record_that_the_environment_does_not_repeat_makes_no_dataset(
    folder: Path, root: Path
) -> None:
    demonstrations = Demonstrations(folder)
    demonstrations.actions[1] *= 0.5
    with pytest.raises(DemonstrationsError, match=r"episode 0.*does not repeat"):
        export(demonstrations, ID)
    assert minari.list_local_datasets() == {}
    assert not list(root.rglob("*.parquet"))


def test_taken_or_malformed_id_is_refused(root: Path) -> None:
    assert check_dataset_id(ID) == root / ID
    (root / ID).mkdir(parents=True)
    with pytest.raises(InvalidOptionError, match="exists already"):
        check_dataset_id(ID)
    for wrong in ("", "noisy", "a b-v0", "../up-v0"):
        with pytest.raises(InvalidOptionError, match="is not valid"):
            check_dataset_id(wrong)


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    found = builtins.__import__

    def without_minari(name: str, *arguments: object) -> object:
        if name.startswith("minari"):
            raise ImportError(name)
        return found(name, *arguments)

    monkeypatch.setattr(builtins, "__import__", without_minari)
    with pytest.raises(InvalidOptionError, match=r"\[data\]"):
        check_dataset_id(ID)


def test_unwritable_root_is_an_error(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "file" / "below"))
    with pytest.raises(DemonstrationsError, match="cannot write below MINARI_DATASETS_PATH"):
        export(Demonstrations(folder), ID)


@pytest.mark.filterwarnings("ignore:.*is set to None:UserWarning")
@pytest.mark.parametrize("env_id", icd_envs.ENV_IDS)
@pytest.mark.parametrize("storage", ["arrow", "parquet"])
def test_minaris_collector_takes_the_environment(env_id: str, storage: str) -> None:
    env = minari.DataCollector(gym.make(env_id), data_format=storage)
    for seed in (3, None):
        env.reset(seed=seed)
        for _ in range(3):
            env.step(env.action_space.sample())
    dataset = env.create_dataset("icd/collected-v0", algorithm_name="random")
    env.close()
    loaded = minari.load_dataset("icd/collected-v0")
    assert dataset.total_episodes == loaded.total_episodes == 2
    assert_repeats(loaded)
