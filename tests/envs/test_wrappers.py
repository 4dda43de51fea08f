"""Wrappers, around our environments and around hostile ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

from icd_envs import ENV_IDS
from icd_envs.errors import InvalidObservationError, InvalidOptionError, RenderingUnavailableError
from icd_envs.wrappers import FlattenPointCloud, RecordEpisodes, SubsamplePointCloud, video


class Clouds(gym.Env[dict[str, Any], np.ndarray]):
    """Shows given clouds; any size, any type."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012
    action_space = spaces.Box(-1, 1, (3,), np.float32)

    def __init__(self, cloud: np.ndarray, size: int | None = None) -> None:
        size = len(cloud) if size is None else size
        self.cloud = cloud
        self.render_mode = "rgb_array"
        box = spaces.Box(-5, 5, (size, 3), cloud.dtype)
        self.observation_space = spaces.Dict({"achieved_goal": box, "desired_goal": box})

    def reset(self, **_: object) -> tuple[dict[str, Any], dict[str, Any]]:
        return {"achieved_goal": self.cloud, "desired_goal": self.cloud}, {}

    def step(self, action: np.ndarray) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        return *self.reset()[:1], 0.0, False, False, {}

    def render(self) -> np.ndarray:
        return np.zeros((32, 48, 3), np.uint8)


def subsampled(env_id: str, **options: object) -> SubsamplePointCloud:
    return SubsamplePointCloud(gym.make(env_id, split="test", **options), 50, 100)


@pytest.mark.parametrize("env_id", ENV_IDS)
@pytest.mark.parametrize("obs_mode", ["full", "partial"])
def test_kept_points_are_evenly_spaced_and_ends_stay(env_id: str, obs_mode: str) -> None:
    env = subsampled(env_id, obs_mode=obs_mode)
    small, _ = env.reset(seed=0)
    full, _ = env.env.reset(seed=0)
    assert env.observation_space.contains(small)
    assert small.keys() == full.keys()
    for name, count in (("achieved_goal", 50), ("desired_goal", 50), ("scene", 100)):
        assert small[name].shape == (count, 3)
        np.testing.assert_array_equal(small[name][[0, -1]], full[name][[0, -1]])
        assert {p.tobytes() for p in small[name]} <= {p.tobytes() for p in full[name]}
    if obs_mode == "partial":
        hidden = small["achieved_goal_mask"] == 0
        assert not small["achieved_goal"][hidden].any()
    env.close()


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_relabelled_rewards_agree_with_those_of_all_points(env_id: str) -> None:
    env = subsampled(env_id)
    base: Any = env.unwrapped
    env.reset(seed=1)
    actions = base.episode(oracle=True).oracle.actions
    steps = [env.step(action) for action in actions]
    achieved = np.stack([step[0]["achieved_goal"] for step in steps])
    desired = np.stack([step[0]["desired_goal"] for step in steps])
    infos = [step[4] for step in steps]
    rewards = env.compute_reward(achieved, desired, infos)
    assert np.mean(rewards != [step[1] for step in steps]) < 0.03
    assert env.compute_reward(achieved[-1], desired[-1], infos[-1]) == 0.0
    here = [{**i, **{f"goal_{n}": i[n] for n in base.task.parameter_names}} for i in infos]
    np.testing.assert_array_equal(env.compute_reward(achieved, achieved, here), 0.0)
    env.close()


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_flat_vector_holds_every_part(env_id: str) -> None:
    env = FlattenPointCloud(subsampled(env_id))
    vector, _ = env.reset(seed=0)
    parts, _ = env.env.reset(seed=0)
    assert env.observation_space.contains(vector)
    assert env.observation_space.shape == (6 + 2 * 150 + 2 * 300,)
    for name, where in env.slices.items():
        np.testing.assert_array_equal(vector[where], parts[name].ravel())
    env.close()


@pytest.mark.parametrize("wrap", [SubsamplePointCloud, FlattenPointCloud])
def test_wrapped_environment_passes_gymnasiums_check(wrap: type[gym.Wrapper]) -> None:
    env = wrap(gym.make(ENV_IDS[0], split="test"))
    with pytest.warns(UserWarning, match="different from the unwrapped"):
        check_env(env, skip_render_check=True)
    assert env.spec is not None
    again = gym.make(env.spec)
    assert type(again) is wrap
    np.testing.assert_equal(again.reset(seed=0)[0], env.reset(seed=0)[0])
    env.close()
    again.close()


def test_a_million_double_precision_duplicates_become_small_float32() -> None:
    env = SubsamplePointCloud(Clouds(np.ones((1_000_000, 3))), 200)
    observation, _ = env.reset()
    assert observation["achieved_goal"].shape == (200, 3)
    assert observation["achieved_goal"].dtype == np.float32
    assert env.observation_space.contains(observation)


@pytest.mark.parametrize("wrap", [SubsamplePointCloud, FlattenPointCloud])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_cloud_that_is_not_finite_is_refused(wrap: type[gym.Wrapper], value: float) -> None:
    cloud = np.zeros((60, 3))
    cloud[59, 2] = value
    with pytest.raises(InvalidObservationError, match=r"'achieved_goal'.* NaN or infinite"):
        wrap(Clouds(cloud)).reset()


@pytest.mark.parametrize("wrap", [SubsamplePointCloud, FlattenPointCloud])
@pytest.mark.parametrize("count", [0, 59, 61])
def test_cloud_of_changing_size_is_refused(wrap: type[gym.Wrapper], count: int) -> None:
    with pytest.raises(InvalidObservationError, match=rf"\({count}, 3\).* \(60, 3\)"):
        wrap(Clouds(np.zeros((count, 3)), size=60)).reset()


@pytest.mark.parametrize("count", [0, 1, 61, -5, 10.0, True])
def test_impossible_number_of_points_is_refused(count: object) -> None:
    with pytest.raises(InvalidOptionError, match=r"object_points must be an integer in \[2, 60\]"):
        SubsamplePointCloud(Clouds(np.zeros((60, 3))), count)


@pytest.mark.parametrize("wrap", [SubsamplePointCloud, FlattenPointCloud])
def test_environment_without_clouds_is_refused(wrap: type[gym.Wrapper]) -> None:
    with pytest.raises(InvalidOptionError, match="dictionary"):
        wrap(FlattenPointCloud(Clouds(np.zeros((60, 3)))))


def test_one_video_per_recorded_episode(tmp_path: Path) -> None:
    import imageio.v3 as iio

    env = RecordEpisodes(Clouds(np.zeros((2, 3))), str(tmp_path / "new folder"), every=2)
    for _ in range(3):
        env.reset()
        for _ in range(4):
            env.step(np.zeros(3))
    env.close()
    files = sorted((tmp_path / "new folder").iterdir())
    assert [file.name for file in files] == ["episode-0000.mp4", "episode-0002.mp4"]
    assert iio.imread(files[1]).shape == (5, 32, 48, 3)


def test_without_opengl_there_are_no_videos_but_episodes(tmp_path: Path) -> None:
    class Blind(Clouds):
        def render(self) -> np.ndarray:
            raise RenderingUnavailableError("no OpenGL here")

    env = RecordEpisodes(Blind(np.zeros((2, 3))), str(tmp_path))
    with pytest.warns(UserWarning, match="no videos: no OpenGL here"):
        env.reset()
    env.step(np.zeros(3))
    env.reset()
    env.close()
    assert list(tmp_path.iterdir()) == []


def test_video_that_breaks_in_the_middle_leaves_no_file_and_the_episode_alone(
    tmp_path: Path,
) -> None:
    class Failing(Clouds):
        left = 2

        def render(self) -> np.ndarray:
            self.left -= 1
            if self.left < 0:
                raise OSError("No space left on device")
            return super().render()

    env = RecordEpisodes(Failing(np.zeros((2, 3))), str(tmp_path))
    env.reset()
    env.step(np.zeros(3))
    with pytest.warns(UserWarning, match="no videos: No space left"):
        env.step(np.zeros(3))
    assert env.step(np.zeros(3))[1] == 0.0
    env.close()
    assert list(tmp_path.iterdir()) == []


def test_video_needs_imageio(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "find_spec", lambda name: None)
    with pytest.raises(InvalidOptionError, match=r"implicit-contact-diffuser\[video\]"):
        RecordEpisodes(Clouds(np.zeros((2, 3))), str(tmp_path))


def test_video_needs_pictures(tmp_path: Path) -> None:
    with pytest.raises(InvalidOptionError, match="render_mode='rgb_array'"):
        RecordEpisodes(gym.make(ENV_IDS[0]), str(tmp_path))
