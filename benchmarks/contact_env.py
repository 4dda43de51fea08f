"""An environment with a task, ours or yours, for commands that look at scenes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from benchmarks.conditions import Condition, Option, TaskSpec, make_env
from icd_envs.demonstrations import find_task
from icd_envs.tasks.env import ContactEnv


@contextmanager
def contact_env(
    env_id: str, options: tuple[tuple[str, Option], ...] = ()
) -> Iterator[ContactEnv[Any]]:
    """Make the environment, of test scenes unless an option says otherwise; closed at the end.

    Args:
        env_id: as ``gymnasium.make`` takes it.
        options: its arguments, by name.

    Raises:
        InvalidOptionError: unknown environment or option, or an environment without a task.
    """
    find_task(env_id)  # an environment that has none is refused
    env = make_env(TaskSpec(env_id, Condition("looked at", options))).unwrapped
    assert isinstance(env, ContactEnv)
    try:
        yield env
    finally:
        env.close()
