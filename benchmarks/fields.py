"""A field and the test scenes to look at it in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gymnasium as gym

from icd_agent.field.field import SceneField
from icd_agent.field.train import load_field
from icd_agent.weights import LOCAL_FIELD, shipped_folder
from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError, unknown_name
from icd_envs.tasks.env import ContactEnv


@contextmanager
def field_in_test_scenes(
    env_id: str, weights: Path | None
) -> Iterator[tuple[SceneField, ContactEnv[Any]]]:
    """Read a field and make the environment of test scenes, closed at the end.

    Args:
        env_id: which environment.
        weights: folder of the field; None is the package's.

    Raises:
        InvalidOptionError: unknown environment.
        CheckpointError: missing or damaged weights.
    """
    if env_id not in ENV_IDS:
        raise InvalidOptionError(unknown_name("environment id", env_id, ENV_IDS))
    field = load_field(shipped_folder(env_id, LOCAL_FIELD) if weights is None else weights)
    env = gym.make(env_id, split="test").unwrapped
    assert isinstance(env, ContactEnv)
    try:
        yield field, env
    finally:
        env.close()
