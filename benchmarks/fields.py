"""A field and the test scenes to look at it in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.contact_env import contact_env
from benchmarks.parts import local_field
from icd_agent.field.field import SceneField
from icd_agent.field.train import load_field
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
    with contact_env(env_id) as env:
        yield load_field(local_field(env_id, weights)), env
