"""Make a Minari dataset of recorded demonstrations, by playing them through the environment.

An episode of the goal environment needs a goal, and ``reset(seed)`` skips scenes that the clean
expert cannot solve. So an episode is exported exactly if ``reset`` with its seed leads to its
scene; what the environment then observes must equal the record to the bit. Needs the extra
``[data]``.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import gymnasium as gym
import numpy as np

import icd_envs  # noqa: F401  registers the environments
from icd_envs.demonstrations.reader import Demonstrations, RecordedEpisode
from icd_envs.errors import DemonstrationsError, InvalidOptionError

if TYPE_CHECKING:
    from minari.data_collector import EpisodeBuffer

STORAGE: Final = "parquet"
"""Minari's Arrow storage, compressed: the scene clouds repeat at every step."""
INFOS: Final = ("is_success", "complete_rate")


class Exported(NamedTuple):
    """What became of the episodes."""

    path: Path
    episodes: int
    left_out: int
    """Episodes in scenes that ``reset`` skips."""


def check_dataset_id(dataset_id: str) -> Path:
    """Where the dataset will be: below ``MINARI_DATASETS_PATH`` or ``~/.minari/datasets``.

    Raises:
        InvalidOptionError: not an id, or it is taken, or Minari is not installed.
        DemonstrationsError: Minari's folder cannot be made.
    """
    try:
        import minari.dataset._storages.arrow_storage  # noqa: F401  needs pyarrow and pillow
        from minari.dataset.minari_dataset import parse_dataset_id
        from minari.storage import get_dataset_path
    except ImportError as error:
        raise InvalidOptionError(
            f"Minari is not usable ({error}): pip install 'implicit-contact-diffuser[data]'"
        ) from error
    try:
        parse_dataset_id(dataset_id)
    except (ValueError, TypeError) as error:
        raise InvalidOptionError(
            f"Minari id {dataset_id!r} is not valid: name it like icd/cable-routing/noisy-v0"
        ) from error
    try:
        path = Path(get_dataset_path(dataset_id))
    except OSError as error:
        raise DemonstrationsError(
            f"cannot write below MINARI_DATASETS_PATH: {error}: set it to another folder"
        ) from error
    if path.exists():
        raise InvalidOptionError(f"Minari dataset {dataset_id!r} exists already: {path}")
    return path


def export(demonstrations: Demonstrations, dataset_id: str) -> Exported:
    """Make a dataset that ``minari.load_dataset`` loads; it is whole, or not there.

    Observations, rewards and so on are the environment's; every episode carries the seed with
    which ``recover_environment().reset`` leads to its first observation.

    Args:
        demonstrations: what to export.
        dataset_id: name for Minari, e.g. ``icd/cable-routing/noisy-v0``.

    Raises:
        InvalidOptionError: see ``check_dataset_id``.
        DemonstrationsError: the environment does not repeat what was recorded, or the file system
            did not take it.
    """
    path = check_dataset_id(dataset_id)
    from minari import __version__
    from minari.dataset.minari_dataset import parse_dataset_id
    from minari.dataset.minari_storage import MinariStorage
    from minari.namespace import create_namespace, list_local_namespaces

    header = demonstrations.header
    options: dict[str, Any] = {"split": header.split, **header.options}
    env = gym.make(header.env_id, **options)
    try:
        namespace = parse_dataset_id(dataset_id)[0]
        _made(path.parent)
        if namespace is not None and namespace not in list_local_namespaces():
            create_namespace(namespace)
        # A dot keeps an unfinished dataset out of Minari's lists.
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".unfinished-") as temporary:
            storage = MinariStorage.new(
                _made(Path(temporary, "dataset", "data")),
                observation_space=env.observation_space,
                action_space=env.action_space,
                env_spec=env.spec,
                data_format=STORAGE,
            )
            storage.update_metadata(
                {
                    "dataset_id": dataset_id,
                    "minari_version": __version__,
                    "algorithm_name": "scripted expert" + (" with noise" if header.noisy else ""),
                    "description": f"{header.env_id}, base seed {header.seed}",
                }
            )
            storage.update_episodes(_buffers(env, demonstrations))
            count = int(storage.total_episodes)
            os.rename(Path(temporary, "dataset"), path)
    except OSError as error:
        raise DemonstrationsError(f"cannot write {path}: {error}") from error
    finally:
        env.close()
    return Exported(path, count, len(demonstrations) - count)


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _buffers(env: gym.Env[Any, Any], demonstrations: Demonstrations) -> Iterator[EpisodeBuffer]:
    from minari.data_collector import EpisodeBuffer

    count = 0
    for i, episode in enumerate(demonstrations):
        observation, info = env.reset(seed=episode.seed)
        if demonstrations.same_scene(i, info) and episode.steps:
            states, infos, rewards, ends = _play(env, episode, observation, info)
            yield EpisodeBuffer(
                id=count,
                seed=episode.seed,
                observations={name: [state[name] for state in states] for name in observation},
                actions=list(episode.actions),
                rewards=rewards,
                terminations=[terminated for terminated, _ in ends],
                truncations=[truncated for _, truncated in ends],
                infos={name: [info[name] for info in infos] for name in INFOS},
            )
            count += 1


class _Played(NamedTuple):
    states: list[dict[str, Any]]
    infos: list[dict[str, Any]]
    rewards: list[float]
    ends: list[tuple[bool, bool]]


def _play(
    env: gym.Env[Any, Any],
    episode: RecordedEpisode,
    observation: dict[str, Any],
    info: dict[str, Any],
) -> _Played:
    played = _Played([observation], [info], [], [])
    for action in episode.actions:
        observation, reward, terminated, truncated, info = env.step(action)
        played.states.append(observation)
        played.infos.append(info)
        played.rewards.append(float(reward))
        played.ends.append((terminated, truncated))
    terminated, _ = played.ends[-1]
    played.ends[-1] = (terminated, not terminated)
    observed = np.stack([state["observation"] for state in played.states])
    if not np.array_equal(observed, episode.gripper):
        raise DemonstrationsError(
            f"episode {episode.index}, seed {episode.seed}: the environment does not repeat what "
            "was recorded: use the versions of the task and of MuJoCo that it was recorded with"
        )
    return played
