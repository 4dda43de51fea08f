"""Models saved by Stable-Baselines3. Loading one unpickles, which runs whatever is in the file."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np
from gymnasium import Env, Space, spaces

from benchmarks.conditions import TaskSpec, make_env
from icd_envs.api import Episode, FloatArray, Observation
from icd_envs.errors import InvalidOptionError
from icd_envs.wrappers import FlattenPointCloud, SubsamplePointCloud

View = Callable[[Any], Any]

# A file does not say by which algorithm it was saved; these attributes tell.
_TELLTALES: Final = {
    "clip_range": "PPO",
    "target_entropy": "SAC",
    "policy_delay": "TD3",  # and DDPG, which is a TD3
    "rms_prop_eps": "A2C",
    "normalize_advantage": "A2C",
}
_NO_BUFFER: Final[dict[str, Any]] = {
    "replay_buffer_class": None,
    "replay_buffer_kwargs": {},
    "buffer_size": 1,
}
"""Acting needs no replay buffer, and a hindsight buffer would ask for an environment."""


class SB3Agent:
    """A trained model; it takes the deterministic action."""

    def __init__(self, path: Path, env_id: str, device: str) -> None:
        """Load it, from a file that its user trusts.

        Args:
            path: written by ``model.save``.
            env_id: environment it will act in.
            device: of PyTorch.

        Raises:
            InvalidOptionError: missing, damaged, of an unknown algorithm, or trained on something
                else than this environment shows.
        """
        import stable_baselines3

        algorithm = getattr(stable_baselines3, _algorithm(path))
        self._model = algorithm.load(path, device=device, custom_objects=dict(_NO_BUFFER))
        self._view = _view(env_id, self._model.observation_space)

    def reset(self, episode: Episode, seed: int) -> None:
        """Nothing to begin: the policy has no memory."""

    def act(self, observation: Observation) -> FloatArray:
        """Return the model's action, (3,) in [-1, 1]."""
        action, _ = self._model.predict(self._view(observation), deterministic=True)
        return np.asarray(action)


def _algorithm(path: Path) -> str:
    try:
        with zipfile.ZipFile(path) as archive:
            saved = json.loads(archive.read("data"))
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InvalidOptionError(f"{path} is no model of Stable-Baselines3: {error}") from error
    for attribute, algorithm in _TELLTALES.items():
        if attribute in saved:
            return algorithm
    known = ", ".join(dict.fromkeys(_TELLTALES.values()))
    raise InvalidOptionError(f"{path} was saved by an algorithm that is not one of {known}")


def _view(env_id: str, trained_on: Space[Any]) -> View:
    """What turns an observation of the environment into what the model saw."""
    env = make_env(TaskSpec(env_id))
    for space, view in _views(env, trained_on):
        if _shapes(space) == _shapes(trained_on):
            return view
    raise InvalidOptionError(
        f"the model was trained on {_shapes(trained_on)}, {env_id} shows "
        f"{_shapes(env.observation_space)}: besides that, SubsamplePointCloud, and "
        "FlattenPointCloud of all points or of its default selection are known here; write an "
        "agent that shows the model what it knows, see docs/plug-in.md"
    )


def _views(env: Env[Any, Any], trained_on: Space[Any]) -> Iterator[tuple[Space[Any], View]]:
    """The environment as it is, and under the wrappers that make it smaller."""
    yield env.observation_space, lambda observation: observation
    if isinstance(trained_on, spaces.Dict) and {"achieved_goal", "scene"} <= set(trained_on):
        counts = [_shapes(trained_on[name])[0] for name in ("achieved_goal", "scene")]
        with suppress(InvalidOptionError):  # more points than there are
            few = SubsamplePointCloud(env, *counts)
            yield few.observation_space, few.observation
    if isinstance(trained_on, spaces.Box):
        flat, few = FlattenPointCloud(env), SubsamplePointCloud(env)
        flat_few = FlattenPointCloud(few)
        yield flat.observation_space, flat.observation
        yield flat_few.observation_space, lambda seen: flat_few.observation(few.observation(seen))


def _shapes(space: Space[Any]) -> Any:  # noqa: ANN401  a shape, or a dictionary of shapes
    if isinstance(space, spaces.Dict):
        return {name: part.shape for name, part in space.items()}
    return space.shape
