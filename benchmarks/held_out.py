"""States of the noisy expert in test scenes, described as the training data are."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.collect import collect
from benchmarks.described import describe
from benchmarks.executors import InProcess
from icd_agent.states import States
from icd_envs import ENV_IDS
from icd_envs.demonstrations import find_task
from icd_envs.demonstrations.header import Header
from icd_envs.errors import InvalidOptionError, unknown_name


def held_out_states(env_id: str, scenes: int, *, seed: int, field: Path | None) -> States:
    """Record the noisy expert in test scenes, and describe every fifth state.

    Args:
        env_id: which task.
        scenes: how many episodes, one scene each.
        seed: of the scenes.
        field: folder of the field; None is the package's.

    Returns:
        The states, in memory.

    Raises:
        IcdError: unknown environment, missing or damaged weights.
    """
    if env_id not in ENV_IDS:
        raise InvalidOptionError(unknown_name("environment id", env_id, ENV_IDS))
    steps = find_task(env_id).max_steps
    header = Header(env_id=env_id, split="test", seed=seed, steps=steps, episodes=scenes)
    with TemporaryDirectory() as folder:
        data = Path(folder) / "test"
        collect(header, data, InProcess())
        states = describe(env_id, data, field, scenes).states
        return states._replace(features=states.features[:].copy())
