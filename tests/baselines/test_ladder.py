from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from baselines.ladder import OracleSource, make_oracle_points, make_retrieved_chain
from benchmarks.registry import Offer, make_agent
from icd_agent.chain import Placed, PointSpace
from icd_agent.mppi.presets import PAPER
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import shipped_chains, shipped_folder
from icd_envs.api import Oracle
from icd_envs.errors import CheckpointError, InvalidOptionError
from tests.agent.toy_world import ToyWorld, cloud_at
from tests.envs.making import CABLE

RNG = np.random.default_rng(0)


def expert(steps: int) -> Oracle:
    """An expert that goes out along +y, across along +x and back: a U."""
    corners = np.array([[0, 0, 0], [0, 0.3, 0], [0.3, 0.3, 0], [0.3, 0, 0]], float)
    at = np.linspace(0, 3, steps + 1)
    path = np.stack([np.interp(at, range(4), axis) for axis in corners.T], axis=1)
    return Oracle(None, cloud_at(path).astype(np.float32), np.zeros((steps, 3), np.float32))


@pytest.mark.parametrize(("steps", "kept"), [(60, 7), (65, 8), (4, 2), (0, 1)])
def test_chain_is_every_tenth_state_and_the_last_once(steps: int, kept: int) -> None:
    world, oracle = ToyWorld(), expert(steps)
    observation = world.observation()
    space = PointSpace().place(observation)
    chain, clouds, *_ = OracleSource().chain(world.episode(oracle), observation, space, RNG)
    assert len(chain) == kept
    np.testing.assert_array_equal(clouds, chain)
    np.testing.assert_array_equal(chain[-1], oracle.points[-1])
    np.testing.assert_array_equal(chain[:-1], oracle.points[:steps:10][: kept - 1])


@pytest.mark.parametrize(("scene", "factor"), [("present", 1.0), ("goal", 2.0)])
def test_each_solution_is_seen_in_its_own_scene(
    scene: Literal["present", "goal"], factor: float
) -> None:
    world, oracle, goal_oracle = ToyWorld(), expert(20), expert(40)
    episode = replace(world.episode(oracle), goal_oracle=goal_oracle)
    space = Placed(lambda points: 1.0 * points, lambda points: 2.0 * points)
    chain, clouds, *_ = OracleSource(scene).chain(episode, world.observation(), space, RNG)
    assert len(chain) == (3 if scene == "present" else 5)
    assert clouds is not None
    np.testing.assert_array_equal(chain, factor * clouds)


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


def test_retrieved_chains_may_lie_alone_or_beside_their_networks(tmp_path: Path) -> None:
    chains = shipped_folder(CABLE, "chains")
    networks = tmp_path / "icd"
    for part in ("field", "latent", "diffusion"):
        shutil.copytree(shipped_chains(CABLE, part), networks / part)
    shutil.copytree(chains, networks / "chains")
    for folder in (chains, networks):
        name = f"ladder:retrieved-chain@{folder}"
        assert isinstance(make_agent(name, Offer(CABLE)), SubgoalTracker)
    shutil.rmtree(networks / "chains")
    shutil.copytree(shipped_folder("ICDNotebookFolding-v0", "chains"), networks / "chains")
    with pytest.raises(CheckpointError, match="chains was trained with the field"):
        make_retrieved_chain(CABLE, networks)
