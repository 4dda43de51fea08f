"""Every command begins an episode alike."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from baselines.expert import ExpertAgent
from baselines.pc_mppi import make_pc_mppi
from baselines.random_agent import RandomAgent
from benchmarks.beginning import begin, episode_for, privileges
from icd_envs.api import Agent
from tests.bench import toy
from tests.envs.making import CABLE


@pytest.mark.parametrize(
    ("agent", "asked"),
    [(RandomAgent(), []), (ExpertAgent(), ["oracle"]), (make_pc_mppi(), ["simulator"])],
)
def test_an_agent_is_told_what_it_asks_for_and_no_more(agent: Agent, asked: list[str]) -> None:
    assert [part for part, wanted in privileges(agent).items() if wanted] == asked
    env = gym.make(CABLE)
    env.reset(seed=0)
    episode = episode_for(env, agent)
    assert [part for part in privileges(agent) if getattr(episode, part) is not None] == asked
    env.close()


def test_an_agent_that_draws_from_generators_of_nobody_repeats_itself() -> None:
    env = gym.make(toy.ENV, split="test")
    observation, _ = env.reset(seed=0)
    actions = []
    for seed in (3, 3, 4):
        agent = toy.Gambler()
        begin(agent, episode_for(env, agent), seed)
        actions.append([np.asarray(agent.act(observation)) for _ in range(8)])
    np.testing.assert_array_equal(actions[0], actions[1])
    assert not np.array_equal(actions[0], actions[2])
    env.close()
