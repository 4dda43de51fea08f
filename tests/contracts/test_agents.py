"""What must hold for every agent of the benchmark, on every environment."""

from __future__ import annotations

import copy
import dataclasses
import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.registry import AGENTS, Offer, make_agent
from icd_agent.agent import ICDAgent
from icd_agent.field import baked
from icd_agent.field.baked import BakeConfig
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import FOLDER, weights_name
from icd_envs import ENV_IDS
from icd_envs.api import Agent, Episode, FloatArray, SimState
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import global_random_state, make, seed_everything

STEPS = 3
DETERMINISTIC = {"expert", "sac-her"}
"""Agents that draw nothing."""
TRAINED = ("icd", "subgoal-diffuser", "diffusion-policy", "dp3", "sac-her")
"""Agents that live by weights of their own; those built like them are left out for their time."""


@pytest.fixture(scope="module", params=ENV_IDS)
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    env = make(request.param)
    env.reset(seed=0)
    yield env
    env.close()


@pytest.fixture(scope="module")
def start(env: ContactEnv[Any]) -> SimState:
    return env.snapshot()


@pytest.fixture(params=AGENTS)
def agent_name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def agent(agent_name: str, env: ContactEnv[Any]) -> Agent:
    """Every agent."""
    return hurried(make_agent(agent_name, Offer(env.task.env_id)))


@pytest.fixture(autouse=True)
def coarse_grids(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever bakes a field without asking for more."""
    monkeypatch.setattr(baked, "BakeConfig", partial(BakeConfig, fine=0.05, coarse=0.2))


def hurried(agent: Agent) -> Agent:
    """Planners get few samples."""
    tracker = getattr(agent, "tracker", agent)
    if isinstance(tracker, SubgoalTracker):
        tracker.mppi_config = dataclasses.replace(tracker.mppi_config, samples=5, horizon=3)
    return agent


def episode_for(agent: Agent, env: ContactEnv[Any]) -> Episode:
    return env.episode(
        simulator=getattr(agent, "needs_simulator", False),
        oracle=getattr(agent, "needs_oracle", False),
    )


def acted(
    agent: Agent,
    env: ContactEnv[Any],
    start: SimState,
    seed: int,
    steps: int = STEPS,
    disturb: bool = False,
) -> list[bytes]:
    """The actions of a short episode, bit for bit."""
    observation = env.restore(start)
    agent.reset(episode_for(agent, env), seed)
    actions = []
    for step in range(steps):
        if disturb:
            seed_everything(step)
        actions.append(agent.act(observation))
        observation, *_ = env.step(np.asarray(actions[-1]))
    return [np.asarray(action).tobytes() for action in actions]


def test_actions_depend_on_the_seed_and_on_no_global_one(
    env: ContactEnv[Any], start: SimState, agent: Agent, agent_name: str
) -> None:
    seed_everything(7)
    before = global_random_state()
    actions = acted(agent, env, start, seed=1)
    assert global_random_state() == before
    assert acted(agent, env, start, seed=1, disturb=True) == actions
    others = acted(agent, env, start, seed=2, steps=1)
    assert (others == actions[:1]) == (agent_name in DETERMINISTIC)


def test_actions_lie_in_the_box_and_what_was_observed_is_left_alone(
    env: ContactEnv[Any], start: SimState, agent: Agent
) -> None:
    observation = env.restore(start)
    before = copy.deepcopy(observation)
    agent.reset(episode_for(agent, env), 0)
    action: FloatArray = np.asarray(agent.act(observation))
    assert action.shape == (3,)
    assert np.abs(action).max() <= 1.0
    np.testing.assert_equal(observation, before)
    assert env.snapshot().physics.tobytes() == start.physics.tobytes()


@pytest.mark.parametrize("name", TRAINED)
def test_weights_of_a_folder_act_as_those_of_the_package(
    env: ContactEnv[Any], start: SimState, name: str, tmp_path: Path
) -> None:
    env_id = env.task.env_id
    shipped = FOLDER / str(weights_name(env_id))
    there = tmp_path / "weights"
    if name == "icd":
        ICDAgent.from_pretrained(env_id).save_pretrained(there)
    else:
        shutil.copytree(shipped / name, there)
    actions = [
        acted(hurried(make_agent(asked, Offer(env_id))), env, start, seed=1)
        for asked in (name, f"{name}@{there}")
    ]
    assert actions[0] == actions[1]
