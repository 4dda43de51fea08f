"""Environments for the contracts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from icd_envs.tasks.env import ContactEnv
from tests.envs.making import VARIANTS, make


@pytest.fixture(scope="module", params=VARIANTS, ids=str)
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    """Every environment in turn, reset once; a test leaves it usable."""
    env_id, options = request.param
    env = make(env_id, **options)
    env.reset(seed=0)
    yield env
    env.close()
