from __future__ import annotations

import numpy as np
import pytest

from baselines.random_agent import RandomAgent
from icd_envs.api import Agent
from icd_envs.errors import EpisodeStateError
from tests.agent.toy_world import ToyWorld


def test_actions_fill_the_box_and_depend_on_the_seed_only() -> None:
    world, agent = ToyWorld(), RandomAgent()
    draws = []
    for seed in (0, 0, 1):
        agent.reset(world.episode(), seed)
        draws.append(np.array([agent.act(world.observation()) for _ in range(300)]))
    np.testing.assert_array_equal(draws[0], draws[1])
    assert not np.array_equal(draws[0], draws[2])
    assert draws[0].dtype == np.float32
    assert np.abs(draws[0]).max() <= 1
    assert (draws[0].min(axis=0) < -0.9).all()
    assert (draws[0].max(axis=0) > 0.9).all()


def test_is_an_agent_without_privileges_that_must_be_reset() -> None:
    agent = RandomAgent()
    assert isinstance(agent, Agent)
    assert not getattr(agent, "needs_simulator", False)
    with pytest.raises(EpisodeStateError, match="reset"):
        agent.act(ToyWorld().observation())
