"""Record what an environment does: python -m tests.contracts.golden ENV_ID, for a new -vN only.

Positions are kept as integers in units of 10 um and every 20th point of a cloud. Free motion
repeats on any machine to a few units; where a taut cable slides on a clip, a change of 1e-10 m
grows to 1 cm within an episode, so that the goal is compared loosely. What a second file holds of
each choice of options is less: two scenes, and for the default how an episode is observed and paid.
A file that exists is kept as it is.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from icd_envs.tasks.env import ContactEnv
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
"""Units by which the goal may differ, and the distance to it: the end of an episode in contact."""
FAST = 1000
"""Units, here of 10 um/s, by which the gripper's velocity may differ."""

CABLE_OPTIONS: dict[str, dict[str, Any]] = {
    "three": {"num_fixtures": 3},
    "charging": {"cable": "charging"},
    "ethernet": {"cable": "ethernet"},
    "rope": {"cable": "rope"},
}


def variants(env_id: str) -> dict[str, dict[str, Any]]:
    """Options of an id whose episodes are recorded, by name."""
    found: dict[str, dict[str, Any]] = {
        "default": {"reward_type": "dense"},
        "partial": {"obs_mode": "partial"},
    }
    if env_id.startswith("ICDCableRouting"):
        found["contact"] = {"goals": "contact"}
    return found | (CABLE_OPTIONS if env_id.startswith("ICDCableRouting-") else {})


def tolerance(moment: str) -> int:
    """Units by which what was recorded under a name may differ."""
    kind = moment.partition(" ")[0]
    return {"goal": LOOSE, "judged": LOOSE, "velocity": FAST}.get(kind, EXACT)


def quantise(cloud: np.ndarray, every: int = EVERY) -> list[list[int]]:
    """Every 20th point, in units of 10 um."""
    return np.rint(np.asarray(cloud)[::every] / UNIT).astype(int).tolist()


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


def record_variant(env_id: str, name: str) -> dict[str, Any]:
    """What two test scenes look like with some options, by seed and moment."""
    env = make(env_id, **variants(env_id)[name])
    found: dict[str, Any] = {}
    for seed in SEEDS[:2]:
        observation, info = env.reset(seed=seed)
        found[str(seed)] = seen = {
            "start": quantise(observation["achieved_goal"]),
            "scene": quantise(observation["scene"], 5 * EVERY),
            "foreign scene": quantise(observation["goal_scene"], 5 * EVERY),
            "goal": quantise(observation["desired_goal"]),
        }
        for parameter in env.task.parameter_names:
            for key in (parameter, f"goal_{parameter}"):
                seen[key] = quantise(info[key], 1)
        if name == "default":
            seen.update(record_course(env))
    env.close()
    return found


def record_course(env: ContactEnv[Any]) -> dict[str, Any]:
    """How the gripper moves and the episode is judged, under random actions and at its end."""
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    start = env.snapshot()
    found: dict[str, Any] = {}
    for step, action in enumerate(random_actions(123, RANDOM_STEPS[-1]), 1):
        observation, reward, *_, info = env.step(action)
        if step in RANDOM_STEPS:
            found[f"gripper {step}"] = quantise(observation["observation"][:3], 1)
            found[f"velocity {step}"] = quantise(observation["observation"][3:], 1)
            found[f"judged {step}"] = judged(reward, info)
    env.restore(start)
    for action in oracle.actions:
        _, reward, *_, info = env.step(action)
    found["judged end"] = judged(reward, info)
    return found


def judged(reward: float, info: dict[str, Any]) -> list[list[int]]:
    """Reward, success and complete rate, in hundred thousandths."""
    return quantise(np.array([reward, info["is_success"], info["complete_rate"]]), 1)


def write(path: Path, found: dict[str, Any]) -> None:
    """A file that is not there yet; what was recorded once stays as it is."""
    if not path.exists():
        text = json.dumps(found, separators=(",", ":")).replace('],"', '],\n"')
        path.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    for env_id in sys.argv[1:]:
        write(FOLDER / f"{env_id}.json", record(env_id))
        options = {name: record_variant(env_id, name) for name in variants(env_id)}
        write(FOLDER / f"{env_id}-options.json", options)
