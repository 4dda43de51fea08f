"""How agents leave the notebook: python -m docs.tasks.measure_folded_ends icd dp3.

Plays the test scenes of the published rows again (8 to 15 minutes an agent on one core), for the
last table of docs/tasks/notebook-folding.md: of the episodes that end with success, how many are
folded as the expert asks, and how far apart the covers are.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np

from benchmarks.beginning import begin, episode_for
from benchmarks.conditions import DEFAULT, TaskSpec, make_env
from benchmarks.plan import Job, Plan
from benchmarks.registry import Offer, make_agent
from docs.tasks.measure_open_covers import between
from icd_envs.api import Agent
from icd_envs.scenes.notebook_folding import NotebookFoldingScene
from icd_envs.tasks.env import ContactEnv
from icd_envs.tasks.notebook_folding import NotebookFolding


class End(NamedTuple):
    """How an episode ends.

    Attributes:
        success: near to the goal.
        folded: as the expert asks.
        angle: [degrees] between the covers.
    """

    success: bool
    folded: bool
    angle: float


def play(env: ContactEnv[NotebookFoldingScene], agent: Agent, job: Job) -> End:
    """Play one episode to its end."""
    observation, info = env.reset(seed=job.seed)
    begin(agent, episode_for(env, agent), job.agent_seed)
    over = False
    while not over:
        observation, _, terminated, truncated, info = env.step(np.asarray(agent.act(observation)))
        over = terminated or truncated
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    cloud, scene = observation["achieved_goal"], oracle.scene
    assert isinstance(scene, NotebookFoldingScene)
    return End(info["is_success"], bool(env.task.solved(cloud, scene)), between(cloud))


def measure(name: str, episodes: int) -> None:
    """Print one agent's row of the table."""
    task = TaskSpec(NotebookFolding.env_id, DEFAULT)
    env, agent = make_env(task).unwrapped, make_agent(name, Offer(task.env))
    assert isinstance(env, ContactEnv)
    ends = [play(env, agent, job) for job in Plan((name,), (task,), episodes).jobs()]
    wins = [end for end in ends if end.success]
    angles = ", ".join(f"{angle:.0f}" for angle in sorted(end.angle for end in wins))
    print(f"| `{name}` | {len(wins)} | {sum(end.folded for end in wins)} | {angles} |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("agents", nargs="+", help="names as icd-bench run takes them")
    parser.add_argument("--episodes", type=int, default=20)
    options = parser.parse_args()
    for agent_name in options.agents:
        measure(agent_name, options.episodes)
