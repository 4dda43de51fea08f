from __future__ import annotations

import numpy as np
import pytest

from baselines.ladder import OracleSource, make_oracle_points
from icd_agent.chain import PointSpace
from icd_agent.mppi.presets import PAPER
from icd_envs.api import Oracle
from icd_envs.errors import InvalidOptionError
from tests.agent.toy_world import ToyWorld, cloud_at


def expert(steps: int) -> Oracle:
    """An expert that goes out along +y, across along +x and back: a U."""
    corners = np.array([[0, 0, 0], [0, 0.3, 0], [0.3, 0.3, 0], [0.3, 0, 0]], float)
    at = np.linspace(0, 3, steps + 1)
    path = np.stack([np.interp(at, range(4), axis) for axis in corners.T], axis=1)
    return Oracle(None, cloud_at(path).astype(np.float32), np.zeros((steps, 3), np.float32))


@pytest.mark.parametrize(("steps", "kept"), [(60, 7), (65, 8), (4, 2), (0, 1)])
def test_chain_is_every_tenth_state_and_the_last_once(steps: int, kept: int) -> None:
    world, oracle = ToyWorld(), expert(steps)
    chain, clouds = OracleSource(PointSpace()).chain(world.episode(oracle), world.observation())
    assert len(chain) == kept
    np.testing.assert_array_equal(clouds, chain)
    np.testing.assert_array_equal(chain[-1], oracle.points[-1])
    np.testing.assert_array_equal(chain[:-1], oracle.points[:steps:10][: kept - 1])


def test_oracle_points_follow_the_expert_round_the_detour() -> None:
    world, agent = ToyWorld(goal=(0.3, 0.0, 0.0)), make_oracle_points()
    assert agent.mppi_config == PAPER
    assert agent.config.window == 1
    assert agent.needs_oracle
    agent.reset(world.episode(expert(60)), 0)
    path = [world.position]
    for _ in range(80):
        world.step(agent.act(world.observation()))
        path.append(world.position)
    assert np.linalg.norm(world.position - world.goal) < 0.03
    assert np.max(path, axis=0)[1] > 0.2
    assert agent.plan_info is not None
    assert agent.plan_info.subgoal == 6


def test_missing_oracle_is_refused_at_reset() -> None:
    with pytest.raises(InvalidOptionError, match=r"episode\.oracle=None"):
        make_oracle_points().reset(ToyWorld().episode(), 0)
