"""Environments for the contracts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from icd_envs import ENV_IDS
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import make


@pytest.fixture(scope="module", params=ENV_IDS)
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    """Every environment in turn, reset once; a test leaves it usable."""
    env = make(request.param)
    env.reset(seed=0)
    yield env
    env.close()
