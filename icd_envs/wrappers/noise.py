"""Noise on what an agent does and sees; drawn from the seed of the episode alone."""

from __future__ import annotations

from typing import Any, Final

import gymnasium as gym
import numpy as np

from icd_envs.api import SEEN_CLOUDS, Float32Array, Float64Array, FloatArray
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.checks import check_action
from icd_envs.wrappers.checks import box_parts, check_part, is_finite

ACTION_STREAM: Final = 2
OBSERVATION_STREAM: Final = 3
"""Spawn keys; scenes of the splits use 0 and 1."""


class NoisyActions(gym.Wrapper[Any, FloatArray, Any, FloatArray], gym.utils.RecordConstructorArgs):
    """Add Gaussian noise to every action; the agent and its simulator do not know of it.

    An action is clipped to [-1, 1] before the noise is added, so that no larger one drowns it, and
    the sum is clipped by the environment. ``info["action_clipped"]`` speaks of the agent's action.
    """

    def __init__(self, env: gym.Env[Any, Any], std: float) -> None:
        """Wrap.

        Args:
            env: takes actions of 3 numbers in [-1, 1].
            std: standard deviation of each number.

        Raises:
            InvalidOptionError: if ``std`` is no number, negative or not finite.
        """
        gym.utils.RecordConstructorArgs.__init__(self, std=std)
        super().__init__(env)
        self._std = _check_std(std)
        self._rng = _generator(None, ACTION_STREAM)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; without a seed its noise goes on where the last one's ended."""
        result = super().reset(seed=seed, options=options)
        if seed is not None:
            self._rng = _generator(seed, ACTION_STREAM)
        return result

    def step(self, action: FloatArray) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Do almost what was asked for.

        Raises:
            InvalidActionError: if the action is not 3 finite numbers.
        """
        wanted = check_action(action)
        clipped = np.clip(wanted, -1.0, 1.0)
        noise = self._rng.normal(0.0, self._std, 3)
        observation, reward, terminated, truncated, info = super().step(clipped + noise)
        info = {**info, "action_clipped": bool(np.any(clipped != wanted))}
        return observation, reward, terminated, truncated, info


class NoisyObservations(
    gym.Wrapper[dict[str, Float32Array], FloatArray, Any, FloatArray],
    gym.utils.RecordConstructorArgs,
):
    """Add Gaussian noise to the gripper's position and to the present clouds of object and scene.

    Goals stay as they are, as do points that a partial view does not see. An agent with a
    simulator still plans from the true state.
    """

    def __init__(self, env: gym.Env[Any, Any], std: float) -> None:
        """Wrap.

        Args:
            env: observes ``icd_envs.api.Observation``, or its partial form.
            std: [m] standard deviation of each coordinate.

        Raises:
            InvalidOptionError: if ``std`` is no number, negative or not finite, or ``env``
                observes no clouds.
        """
        gym.utils.RecordConstructorArgs.__init__(self, std=std)
        super().__init__(env)
        self._std = _check_std(std)
        self._rng = _generator(None, OBSERVATION_STREAM)
        self._spaces = box_parts(env, type(self).__name__)
        for name in ("observation", *SEEN_CLOUDS):
            if name not in self._spaces:
                raise InvalidOptionError(
                    f"NoisyObservations needs an environment that observes {name!r}, this one has "
                    f"{', '.join(map(repr, self._spaces))}"
                )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Float32Array], dict[str, Any]]:
        """Begin an episode; without a seed its noise goes on where the last one's ended.

        Raises:
            InvalidObservationError: on a wrong shape, NaN or infinite values.
        """
        observation, info = super().reset(seed=seed, options=options)
        if seed is not None:
            self._rng = _generator(seed, OBSERVATION_STREAM)
        return self._noisy(observation), info

    def step(
        self, action: FloatArray
    ) -> tuple[dict[str, Float32Array], Any, bool, bool, dict[str, Any]]:
        """Show almost what is there.

        Raises:
            InvalidObservationError: on a wrong shape, NaN or infinite values.
        """
        observation, reward, terminated, truncated, info = super().step(action)
        return self._noisy(observation), reward, terminated, truncated, info

    def _noisy(self, observation: dict[str, Float32Array]) -> dict[str, Float32Array]:
        shown = {n: check_part(n, observation[n], s.shape) for n, s in self._spaces.items()}
        motion = shown["observation"].astype(np.float64)
        motion[:3] += self._rng.normal(0.0, self._std, 3)
        shown["observation"] = self._within("observation", motion)
        for name in SEEN_CLOUDS:
            noise = self._rng.normal(0.0, self._std, shown[name].shape)
            if f"{name}_mask" in shown:
                noise *= shown[f"{name}_mask"][:, None]
            shown[name] = self._within(name, shown[name] + noise)
        return shown

    def _within(self, name: str, value: Float64Array) -> Float32Array:
        space = self._spaces[name]
        return np.clip(value, space.low, space.high).astype(np.float32)


def _check_std(std: float) -> float:
    if not (is_finite(std) and std >= 0.0):
        raise InvalidOptionError(f"std must be finite and >= 0, got {std!r}")
    return std


def _generator(seed: int | None, stream: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(stream,)))
