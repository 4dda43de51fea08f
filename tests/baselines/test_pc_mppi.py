from __future__ import annotations

import numpy as np

from baselines.pc_mppi import make_pc_mppi
from icd_agent.mppi.presets import PAPER
from tests.agent.toy_world import ToyWorld


def test_goes_straight_for_the_goal_with_the_papers_settings() -> None:
    world, agent = ToyWorld(goal=(0.2, 0.1, 0.0)), make_pc_mppi()
    assert agent.mppi_config == PAPER
    assert agent.needs_simulator
    assert not agent.needs_oracle
    agent.reset(world.episode(), 0)
    for _ in range(25):
        world.step(agent.act(world.observation()))
    assert np.linalg.norm(world.position - world.goal) < 0.02
    assert agent.plan_info is not None
    assert agent.plan_info.chain_length == 1
