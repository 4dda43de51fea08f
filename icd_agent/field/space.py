"""The cost space of descriptors: how far apart object states are for contact."""

from __future__ import annotations

import numpy as np
import torch

from icd_agent.chain import Features, Placed
from icd_agent.completion import seen_scene
from icd_agent.field.baked import BakeConfig, BakedField, ask
from icd_agent.field.field import SceneField
from icd_agent.field.train import load_field
from icd_agent.weights import LOCAL_FIELD, shipped_folder
from icd_envs.api import Float32Array, FloatArray, Observation


class FieldSpace:
    """Descriptors of every object point in the scene that is there."""

    def __init__(self, field: SceneField, bake: BakeConfig | None = None) -> None:
        """Choose.

        Args:
            field: in evaluation mode.
            bake: grids of the present scene; None is the default.
        """
        self._field = field
        self._bake = bake

    @classmethod
    def shipped(cls, env_id: str, part: str = LOCAL_FIELD) -> FieldSpace:
        """With the weights that come with the package for this environment.

        Args:
            env_id: id of the environment.
            part: which field: the local one, or ``icd_agent.weights.GLOBAL_FIELD``.

        Raises:
            CheckpointError: there are none, or they are damaged.
        """
        return cls(load_field(shipped_folder(env_id, part)))

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        """Bake the present scene; the goal's, if it is another, is asked exactly."""
        scene = seen_scene(observation)
        places = np.concatenate([observation["achieved_goal"], observation["desired_goal"]])
        here = BakedField(self._field, scene, places, self._bake).features
        return Placed(here, _there(self._field, observation) if foreign else here)


class ExactFieldSpace:
    """The same without grids: for few states, as those that are encoded."""

    def __init__(self, field: SceneField) -> None:
        """Choose.

        Args:
            field: in evaluation mode.
        """
        self._field = field

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        """Look at the present scene, and at the goal's if it is another."""
        here = exact_features(self._field, seen_scene(observation))
        return Placed(here, _there(self._field, observation) if foreign else here)


def _there(field: SceneField, observation: Observation) -> Features:
    return exact_features(field, observation["goal_scene"])


def exact_features(field: SceneField, scene: FloatArray) -> Features:
    """Descriptors straight from the network: about 20 microseconds a point.

    Args:
        field: in evaluation mode.
        scene: (M, 3) [m] scene cloud, world frame, of points that were seen.
    """
    with torch.no_grad():
        code = field.encoder(torch.from_numpy(np.ascontiguousarray(scene, np.float32))[None])

    def features(points: FloatArray) -> Float32Array:
        found = ask(field, code, np.reshape(points, (-1, 3))).descriptor[0]
        return found.numpy().reshape(*np.shape(points)[:-1], -1)

    return features
