"""The goal as the only subgoal: with the paper's planner, and with ICD's."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from baselines.ndf_mppi import make_ndf_mppi_improved
from baselines.pc_mppi import make_pc_mppi, make_pc_mppi_improved
from benchmarks.registry import Offer, make_agent
from icd_agent.agent import ICDAgent
from icd_agent.mppi.presets import PAPER
from tests.agent.toy_world import ToyWorld
from tests.envs.making import CABLE


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


@pytest.mark.parametrize("env_id", [CABLE, "ICDNotebookFolding-v0"])
def test_improved_ones_have_icds_planner_and_cost_and_no_chain(env_id: str) -> None:
    icd = make_agent("icd", Offer(env_id))
    assert isinstance(icd, ICDAgent)
    env = gym.make(env_id).unwrapped
    observation, _ = env.reset(seed=0)
    now = observation["achieved_goal"]
    theirs = icd.tracker.space.place(observation)
    for agent in (make_pc_mppi_improved(env_id), make_ndf_mppi_improved(env_id)):
        assert agent.mppi_config == icd.tracker.mppi_config != PAPER
        assert agent.config.collision_weight == icd.tracker.config.collision_weight
        assert agent.config.replan_every is None
    ours = agent.space.place(observation)
    np.testing.assert_array_equal(ours.here(now), theirs.here(now))
    env.close()
