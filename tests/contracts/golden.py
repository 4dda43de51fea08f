"""Record what an environment does: python -m tests.contracts.golden ENV_ID, for a new -vN only.

Positions are kept as integers in units of 10 um and every 20th point of a cloud. Free motion
repeats on any machine to a few units; where a taut cable slides on a clip, a change of 1e-10 m
grows to 1 cm within an episode, so that the goal is compared loosely.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from tests.envs.making import make, random_actions

FOLDER = Path(__file__).parent / "golden"
SEEDS = range(5)
UNIT = 1e-5
"""[m]"""
EVERY = 20
RANDOM_STEPS = (1, 10, 20, 30)
"""Steps of fixed random actions after which the object is looked at."""
EXPERT_STEPS = (20, 40)
"""Steps of the expert after which the object is looked at: it touches no fixture yet."""

EXACT = 3
"""Units by which a position may differ that follows without contact."""
LOOSE = 3000
"""Units by which the goal may differ: the end of a whole episode in contact."""


def quantise(cloud: np.ndarray) -> list[list[int]]:
    """Every 20th point, in units of 10 um."""
    return np.rint(cloud[::EVERY] / UNIT).astype(int).tolist()


def record(env_id: str) -> dict[str, Any]:
    """What five test scenes look like and how the object moves in them, by seed and moment."""
    env = make(env_id)
    actions = random_actions(123, RANDOM_STEPS[-1])
    found: dict[str, Any] = {}
    for seed in SEEDS:
        observation, _ = env.reset(seed=seed)
        oracle = env.episode(oracle=True).oracle
        assert oracle is not None
        seen = {"start": quantise(observation["achieved_goal"])}
        seen["scene"] = quantise(observation["scene"])
        seen["goal"] = quantise(observation["desired_goal"])
        for step in EXPERT_STEPS:
            seen[f"expert {step}"] = quantise(oracle.points[step])
        for step, action in enumerate(actions, 1):
            observation, *_ = env.step(action)
            if step in RANDOM_STEPS:
                seen[f"random {step}"] = quantise(observation["achieved_goal"])
        found[str(seed)] = seen
    env.close()
    return found


if __name__ == "__main__":
    for env_id in sys.argv[1:]:
        text = json.dumps(record(env_id), separators=(",", ":")).replace('],"', '],\n"')
        (FOLDER / f"{env_id}.json").write_text(text + "\n", encoding="utf-8")
