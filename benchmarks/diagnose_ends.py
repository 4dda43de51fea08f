"""What ``icd-bench diagnose ends`` does: is a goal of another scene understood?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, Literal

import numpy as np

from baselines.subgoal_diffuser import chains_of_places
from benchmarks.conditions import parse_options
from benchmarks.console import Values
from benchmarks.contact_env import contact_env
from benchmarks.parts import check_places
from icd_agent.chain import CostSpace
from icd_agent.completion import Completion
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.generate import Generator
from icd_agent.field.space import ExactFieldSpace
from icd_agent.networks import load_networks, load_shipped
from icd_agent.presets import PRESETS, best_preset
from icd_agent.weights import SUBGOAL_DIFFUSER, shipped_folder
from icd_envs.errors import InvalidOptionError

SOLVED = 0.0
"""Reward."""


Generates = Literal["icd", "subgoal-diffuser"]
"""Agents that generate the last subgoal for a goal of another scene."""


def diagnose(
    env_id: str,
    scenes: int,
    *,
    agent: Generates = "icd",
    seed: int,
    chains: int,
    weights: Path | None,
    options: Sequence[str] = (),
) -> Values:
    """Ask for chains at the start of test episodes, and judge their last subgoals as states.

    Args:
        env_id: an environment whose goals are of another scene.
        scenes: how many.
        agent: who generates them.
        seed: of the first scene; the others follow.
        chains: asked for in each scene.
        weights: folder of the agent's networks, as training leaves it; None is the package's.
        options: of the task, each as ``name=value``; in a partial view hidden points of the object
            are guessed, as the agent does.

    Returns:
        ``right``, the share of last subgoals that solve the task; ``right_scenes``, the share of
        scenes in which most of them do; ``goal_right``, that of scenes in which the goal would, had
        its cloud been kept where it is; ``rights``, how many solve it, scene by scene.

    Raises:
        InvalidOptionError: unknown environment or option, or goals of the present scene: there the
            last subgoal is not generated.
        CheckpointError: missing or damaged weights.
    """
    right, kept = np.zeros((scenes, chains), bool), np.zeros(scenes, bool)
    with contact_env(env_id, parse_options(options)) as env:
        source, space = MAKERS[agent](env_id, weights)
        for i in range(scenes):
            observation, info = env.reset(seed=seed + i)
            goal, episode = observation["desired_goal"], env.episode()
            observation = Completion(episode.canonical_cloud)(observation)
            if not episode.foreign_goal:
                raise InvalidOptionError(
                    f"env={env_id!r} has goals of the present scene, which are the last subgoal: "
                    "give an adaptation task"
                )
            placed = space.place(observation, foreign=True)
            rng = np.random.default_rng([seed + i])
            for j in range(chains):
                clouds = source.chain(episode, observation, placed, rng).clouds
                assert clouds is not None
                end = clouds[-1].astype(np.float32)
                right[i, j] = env.compute_reward(end, goal, info) == SOLVED
            kept[i] = env.compute_reward(goal, goal, info) == SOLVED
    return {
        "scenes": scenes,
        "chains": chains,
        "right": float(right.mean()),
        "right_scenes": float((right.mean(axis=1) > 0.5).mean()),
        "goal_right": float(kept.mean()),
        "rights": " ".join(map(str, right.sum(axis=1))),
    }


def _contacts(env_id: str, weights: Path | None) -> tuple[DiffusedSource, CostSpace]:
    """ICD's chains, encoded in the exact field: no grid is baked, nothing is followed."""
    networks = load_shipped(env_id) if weights is None else load_networks(weights, env_id)
    check_places(networks.diffusion)
    settings = PRESETS[best_preset(env_id)].chain
    generator = Generator(networks.diffusion, networks.latent, settings)
    source = DiffusedSource(networks.encoded, networks.latent, generator)
    return source, ExactFieldSpace(networks.encoded)


def _places(env_id: str, weights: Path | None) -> tuple[DiffusedSource, CostSpace]:
    folder = weights or shipped_folder(env_id, SUBGOAL_DIFFUSER)
    return chains_of_places(env_id, folder, PRESETS[best_preset(env_id)].chain)


MAKERS: Final[dict[Generates, Callable[[str, Path | None], tuple[DiffusedSource, CostSpace]]]] = {
    "icd": _contacts,
    "subgoal-diffuser": _places,
}
