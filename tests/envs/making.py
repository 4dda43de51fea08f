"""Environments, actions and comparisons that several test files share."""

from __future__ import annotations

import hashlib
import random
from typing import Any

import gymnasium as gym
import numpy as np

from icd_envs import ENV_IDS
from icd_envs.api import Float32Array, Observation
from icd_envs.physics.plant import Plant
from icd_envs.tasks.env import ContactEnv

CABLE = "ICDCableRouting-v0"

VARIANTS: list[tuple[str, dict[str, Any]]] = [(env_id, {}) for env_id in ENV_IDS] + [
    (CABLE, {"num_fixtures": 1, "cable": "charging", "obs_mode": "partial"}),
    ("ICDCableRoutingAdaptation-v0", {"goals": "contact"}),
]
"""Every environment as it is, and options that change what the contracts speak of."""


def make(env_id: str = CABLE, **options: object) -> ContactEnv[Any]:
    """An environment without wrappers, on test scenes."""
    env = gym.make(env_id, **{"split": "test", **options}).unwrapped
    assert isinstance(env, ContactEnv)
    return env


def remake(env: ContactEnv[Any], **changes: object) -> gym.Env[Any, Any]:
    """Another environment of the same options, as most users have it: wrapped."""
    assert env.spec is not None
    return gym.make(env.spec.id, **{**env.spec.kwargs, **changes})


def bare(env: gym.Env[Any, Any]) -> ContactEnv[Any]:
    """The environment inside its wrappers."""
    assert isinstance(env.unwrapped, ContactEnv)
    return env.unwrapped


def random_actions(seed: int, *shape: int) -> Float32Array:
    """(*shape, 3) in [-1, 1]."""
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (*shape, 3)).astype(np.float32)


def play(env: ContactEnv[Any], actions: Float32Array) -> list[Observation]:
    """What is observed after each action."""
    return [env.step(action)[0] for action in actions]


def digest(observations: list[Observation]) -> str:
    """Fingerprint of every bit observed."""
    found = hashlib.sha256()
    for observation in observations:
        for name in sorted(observation):
            found.update(name.encode() + observation[name].tobytes())  # type: ignore[literal-required]
    return found.hexdigest()


def plant_of(env: ContactEnv[Any]) -> Plant:
    """The physics behind an environment, to break it on purpose."""
    assert env._problem is not None
    return env._problem.plant


def state_bits(env: ContactEnv[Any]) -> bytes:
    """The whole simulation state."""
    return env.snapshot().physics.tobytes()


def seed_everything(seed: int) -> None:
    """Seed every global generator, none of which must matter."""
    import torch  # not in every process that imports this file

    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    torch.manual_seed(seed)


def global_random_state() -> tuple[object, ...]:
    """Of every global generator, all of which must be left alone."""
    import torch

    numpys = repr(np.random.get_state())  # noqa: NPY002
    return random.getstate(), numpys, torch.get_rng_state().numpy().tobytes()
