"""Environments to be mistreated."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from icd_envs.api import SimState
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import VARIANTS, make


@pytest.fixture(scope="module", params=VARIANTS, ids=str)
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    """Every environment in turn, reset once; a test leaves it usable and in the same scene."""
    env_id, options = request.param
    env = make(env_id, **options)
    env.reset(seed=0)
    yield env
    env.close()


@pytest.fixture(scope="module")
def start(env: ContactEnv[Any]) -> SimState:
    """Where its episode begins, to come back to for less than a reset."""
    return env.snapshot()
