"""Draw cable routing's archetype of failure: python -m docs.tasks.render_wrong_side.

It is PC-MPPI's own, in the scene whose index is given (about two minutes on two cores).
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium as gym

from baselines.pc_mppi import make_pc_mppi
from benchmarks.suites import episode_seed
from docs.tasks.filming import all_views, save

ENV_ID = "ICDCableRouting-v0"


def draw(index: int, threads: int) -> None:
    """The last frame of a PC-MPPI episode, from every camera."""
    env = gym.make(ENV_ID, split="test")
    seed = episode_seed(0, ENV_ID, index)
    observation, info = env.reset(seed=seed)
    unwrapped: Any = env.unwrapped
    agent = make_pc_mppi()
    agent.reset(unwrapped.episode(simulator=True, threads=threads), seed)
    ended = False
    while not ended:
        observation, _, terminated, truncated, info = env.step(agent.act(observation))
        ended = terminated or truncated
    state = unwrapped.snapshot()
    env.close()
    save("cable-routing-wrong-side", all_views(ENV_ID, seed, state))
    print(f"index {index}: success {info['is_success']}, complete {info['complete_rate']}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--index", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    draw(options.index, options.threads)
