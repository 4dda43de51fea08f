"""Draw the pictures of docs/tasks/cable-routing.md: python docs/tasks/render_cable_routing.py.

Start, goal and success come from one test scene. The wrong-side failure is PC-MPPI's own: the
script runs it in the scene whose index is given (about two minutes on two cores).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import gymnasium as gym
import imageio.v3 as iio
import numpy as np

import icd_envs  # noqa: F401  registers the environments
from baselines.pc_mppi import make_pc_mppi
from benchmarks.suites import episode_seed

ENV_ID = "ICDCableRouting-v0"
FOLDER = Path(__file__).parent / "img"


def make(camera: str) -> gym.Env[Any, Any]:
    """The environment with pictures of 480 x 360."""
    return gym.make(ENV_ID, split="test", render_mode="rgb_array", camera=camera)


def draw_expert(index: int) -> None:
    """Start with the goal in red, the way there, and success."""
    env = make("overview")
    env.reset(seed=episode_seed(0, ENV_ID, index))
    unwrapped: Any = env.unwrapped
    oracle = unwrapped.episode(oracle=True).oracle
    frames = [env.render()]
    for action in oracle.actions:
        env.step(action)
        frames.append(env.render())
    env.close()
    iio.imwrite(FOLDER / "cable-routing-start-and-goal.png", frames[0])
    iio.imwrite(FOLDER / "cable-routing-success.png", frames[-1])
    shown = np.linspace(0, len(frames) - 1, 12).round().astype(int)
    rows = [np.concatenate([frames[i][::2, ::2] for i in shown[k : k + 4]], 1) for k in (0, 4, 8)]
    iio.imwrite(FOLDER / "cable-routing-expert.png", np.concatenate(rows))


def draw_failure(index: int, threads: int) -> None:
    """The last frame of a PC-MPPI episode, from above and from the side."""
    env = make("overview")
    seed = episode_seed(0, ENV_ID, index)
    observation, info = env.reset(seed=seed)
    unwrapped: Any = env.unwrapped
    agent = make_pc_mppi()
    agent.reset(unwrapped.episode(simulator=True, threads=threads), seed)
    ended = False
    while not ended:
        observation, _, terminated, truncated, info = env.step(agent.act(observation))
        ended = terminated or truncated
    views = [env.render()]
    state = unwrapped.snapshot()
    env.close()
    for camera in ("side", "top"):
        env = make(camera)
        env.reset(seed=seed)
        other: Any = env.unwrapped
        other.restore(state)
        views.append(env.render())
        env.close()
    iio.imwrite(FOLDER / "cable-routing-wrong-side.png", np.concatenate(views, 1))
    print(f"index {index}: success {info['is_success']}, complete {info['complete_rate']}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--expert-index", type=int, default=1)
    parser.add_argument("--failure-index", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    draw_expert(options.expert_index)
    draw_failure(options.failure_index, options.threads)
