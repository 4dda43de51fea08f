"""Smaller clouds for learners that cannot take 2,400 points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from icd_envs.api import Float32Array, Float64Array, FloatArray
from icd_envs.errors import InvalidOptionError
from icd_envs.wrappers.checks import box_parts, check_part

OBJECT_PARTS: Final = ("achieved_goal", "achieved_goal_mask", "desired_goal")
SCENE_PARTS: Final = ("scene", "scene_mask", "goal_scene")


Infos = Mapping[str, Any] | Sequence[Mapping[str, Any]] | NDArray[np.object_]


class SubsamplePointCloud(
    gym.ObservationWrapper[dict[str, Float32Array], Any, Any], gym.utils.RecordConstructorArgs
):
    """Keep a fixed, evenly spaced selection of the points of object and scene.

    Object clouds are in material order, so that every kept point stays the same material point,
    both ends included. Scene clouds are drawn at random, fixtures first: even spacing keeps the
    share of every part. Observations stay dictionaries of float32, masks go with their clouds.
    """

    def __init__(
        self, env: gym.Env[Any, Any], object_points: int = 50, scene_points: int = 256
    ) -> None:
        """Choose the points.

        Args:
            env: an environment that observes ``icd_envs.api.Observation``.
            object_points: points kept of ``achieved_goal`` and ``desired_goal``, at least 2.
            scene_points: points kept of ``scene`` and ``goal_scene``, at least 2.

        Raises:
            InvalidOptionError: on fewer than 2 points, or more than there are.
        """
        gym.utils.RecordConstructorArgs.__init__(
            self, object_points=object_points, scene_points=scene_points
        )
        super().__init__(env)
        self._parts = box_parts(env, type(self).__name__)
        wanted = {
            **dict.fromkeys(OBJECT_PARTS, ("object_points", object_points)),
            **dict.fromkeys(SCENE_PARTS, ("scene_points", scene_points)),
        }
        self._kept: dict[str, NDArray[np.int64]] = {}
        for name in self._parts.keys() & wanted.keys():
            option, count = wanted[name]
            there = self._parts[name].shape[0]
            if type(count) is not int or not 2 <= count <= there:
                raise InvalidOptionError(
                    f"{option} must be an integer in [2, {there}], the points of {name!r}; "
                    f"got {count!r}"
                )
            self._kept[name] = np.linspace(0, there - 1, count).round().astype(np.int64)
        kept: dict[str, spaces.Space[Any]] = {
            name: self._keep_space(name, space) for name, space in self._parts.items()
        }
        self.observation_space = spaces.Dict(kept)  # type: ignore[assignment]

    def observation(self, observation: dict[str, Any]) -> dict[str, Float32Array]:
        """Keep the chosen points.

        Raises:
            InvalidObservationError: on a wrong shape, NaN or infinite values.
        """
        checked = {n: check_part(n, observation[n], s.shape) for n, s in self._parts.items()}
        return {
            name: value[self._kept[name]] if name in self._kept else value
            for name, value in checked.items()
        }

    def compute_reward(
        self, achieved_goal: FloatArray, desired_goal: FloatArray, info: Infos
    ) -> float | Float64Array:
        """Reward of relabelled goals, from the kept points.

        ``step`` judges by all points; with two or more kept per link of a cable, the two agree
        except where it just touches the edge of a throat.

        Args:
            achieved_goal: (n, 3) or (B, n, 3) [m], n = ``object_points``.
            desired_goal: the same shape.
            info: the step's ``info``, or B of them.
        """
        reward: float | Float64Array = self.env.get_wrapper_attr("compute_reward")(
            achieved_goal, desired_goal, info
        )
        return reward

    def _keep_space(self, name: str, space: spaces.Box) -> spaces.Box:
        low, high = space.low.astype(np.float32), space.high.astype(np.float32)
        kept = self._kept.get(name, slice(None))
        return spaces.Box(low[kept], high[kept], dtype=np.float32)
