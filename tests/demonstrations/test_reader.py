from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.conditions import TaskSpec
from benchmarks.plan import Plan
from icd_envs import ENV_IDS
from icd_envs.demonstrations import Demonstrations, demonstrate, find_task
from icd_envs.demonstrations.header import FILE_NAME, shard_path
from icd_envs.demonstrations.shard import encode
from icd_envs.errors import DemonstrationsError
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.tasks.problem import scene_rng
from tests.demonstrations.making import (
    STEPS,
    make_folder,
    make_header,
    make_recording,
)
from tests.envs.making import CABLE, make


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three short episodes in two shards."""
    return make_folder(tmp_path_factory.mktemp("demonstrations"))


@pytest.fixture(scope="module")
def demonstrations(folder: Path) -> Demonstrations:
    """The same, opened."""
    return Demonstrations(folder)


def test_episodes_are_those_of_the_seeds(demonstrations: Demonstrations) -> None:
    assert len(demonstrations) == 3
    seeds = [job.seed for job in Plan(("expert-noisy",), (TaskSpec(CABLE),), 3, seed=5).jobs()]
    assert demonstrations.seeds.tolist() == seeds
    for episode, seed in zip(demonstrations, seeds, strict=True):
        shown = demonstrate(CABLE, seed=seed, noisy=True)
        assert episode.seed == seed
        assert episode.steps == STEPS
        assert episode.actions.tobytes() == shown.actions[:STEPS].tobytes()
        assert episode.gripper.tobytes() == shown.gripper[: STEPS + 1].tobytes()
        np.testing.assert_allclose(episode.points, shown.points[: STEPS + 1], atol=1e-7, rtol=0)
        assert episode.points.shape == (STEPS + 1, 200, 3)
        assert episode.points.dtype == np.float32


def test_replay_is_exact_to_the_bit(demonstrations: Demonstrations) -> None:
    shown = demonstrate(CABLE, seed=int(demonstrations.seeds[1]), noisy=True)
    assert demonstrations.replay(1).tobytes() == shown.points[: STEPS + 1].tobytes()


def test_flat_arrays_hold_the_episodes_one_after_another(demonstrations: Demonstrations) -> None:
    for i, episode in enumerate(demonstrations):
        first = demonstrations.first_state[i]
        np.testing.assert_array_equal(demonstrations.nodes[first + 2], episode.nodes[2])
        np.testing.assert_array_equal(
            demonstrations.actions[demonstrations.first_step[i] + 1], episode.actions[1]
        )
    assert demonstrations.first_state[-1] == len(demonstrations.nodes)
    assert demonstrations.first_step[-1] == len(demonstrations.actions)
    batch = demonstrations.points(demonstrations.nodes[[0, 9]])
    np.testing.assert_array_equal(batch[1], demonstrations.episode(1).points[2])


def test_scene_is_the_one_that_the_environment_shows(demonstrations: Demonstrations) -> None:
    env = make(split="train")
    for i, episode in enumerate(demonstrations):
        observation, info = env.reset(seed=episode.seed)
        scene = demonstrations.scene(i)
        again = demonstrations.scene(i)
        assert scene.cloud.tobytes() == again.cloud.tobytes()
        if demonstrations.same_scene(i, info):
            assert scene.cloud.tobytes() == observation["scene"].tobytes()
            assert episode.gripper[0].tobytes() == observation["observation"].tobytes()
        distance = BoxUnion(scene.boxes)(scene.cloud[:800].astype(np.float64))
        assert np.abs(distance).max() < 1e-5
    env.close()


def test_missing_shard_is_an_error_unless_partial(folder: Path, tmp_path: Path) -> None:
    for name in (FILE_NAME, shard_path(folder, 1).name):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    with pytest.raises(DemonstrationsError, match=r"shard-00000\.npz is missing"):
        Demonstrations(tmp_path)
    partial = Demonstrations(tmp_path, partial=True)
    assert partial.index.tolist() == [2]
    shard_path(tmp_path, 1).unlink()
    with pytest.raises(DemonstrationsError, match="no finished shard"):
        Demonstrations(tmp_path, partial=True)


def test_shard_of_another_size_is_an_error(folder: Path, tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_bytes(make_header(episodes=2, shard_episodes=1).to_json())
    for number in (0, 1):
        shard_path(tmp_path, number).write_bytes(shard_path(folder, 0).read_bytes())
    with pytest.raises(DemonstrationsError, match="has 2 episodes instead of 1"):
        Demonstrations(tmp_path)


def test_shards_of_different_objects_are_an_error(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_bytes(make_header(episodes=2, shard_episodes=1).to_json())
    shard_path(tmp_path, 0).write_bytes(encode([make_recording()]))
    other = make_recording(nodes=np.zeros((3, 5, 3), np.float32))
    shard_path(tmp_path, 1).write_bytes(encode([other]))
    with pytest.raises(DemonstrationsError, match="nodes"):
        Demonstrations(tmp_path)


def test_task_with_options_is_read_as_it_was_recorded(tmp_path: Path) -> None:
    folder = make_folder(tmp_path, episodes=4, options={"goals": "contact", "num_fixtures": 1})
    demonstrations = Demonstrations(folder)
    assert demonstrations.solved.shape[1] == 1
    task = find_task(CABLE, {"goals": "contact", "num_fixtures": 1})
    for i, episode in enumerate(demonstrations):
        rng = scene_rng("train", episode.seed)
        assert demonstrations.scene(i).scene.contacts == task.draw_scenes(rng).scene.contacts
        np.testing.assert_allclose(demonstrations.replay(i), episode.points, atol=1e-6)


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_every_task_can_be_recorded_and_read(tmp_path: Path, env_id: str) -> None:
    demonstrations = Demonstrations(make_folder(tmp_path, episodes=2, env_id=env_id))
    for i, episode in enumerate(demonstrations):
        np.testing.assert_allclose(demonstrations.replay(i), episode.points, atol=1e-6)
        assert demonstrations.scene(i).cloud.shape == (1000, 3)


def test_scene_of_another_version_is_an_error(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_bytes(make_header(episodes=1).to_json())
    shard_path(tmp_path, 0).write_bytes(encode([make_recording()]))
    foreign = Demonstrations(tmp_path)
    for call in (foreign.scene, foreign.replay):
        with pytest.raises(DemonstrationsError, match="episode 0, seed 0: the scene differs"):
            call(0)


def test_motion_of_another_version_is_an_error(folder: Path) -> None:
    demonstrations = Demonstrations(folder)
    demonstrations.actions[0] += 0.1
    with pytest.raises(DemonstrationsError, match="the motion differs"):
        demonstrations.replay(0)
    demonstrations._scene_ids[0] = b"0"
    with pytest.raises(DemonstrationsError, match="the compiled scene differs"):
        demonstrations.replay(0)
