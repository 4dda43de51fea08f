"""What ``icd-bench diagnose field`` does: the field against the truth, in test scenes."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import torch
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from scipy.stats import kendalltau

from benchmarks.console import Values
from benchmarks.fields import field_in_test_scenes
from icd_agent.chain import Features
from icd_agent.field.field import SceneField
from icd_agent.field.space import FieldSpace, exact_features
from icd_agent.field.supervision import above_floor, supervise
from icd_agent.mppi.costs import nearest_subgoal_cost, squared_distance
from icd_agent.mppi.planner import MPPI
from icd_agent.mppi.presets import ADAPTIVE
from icd_envs.api import Float32Array, FloatArray, Observation, Oracle
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.tasks.env import ContactEnv

NEAR_SURFACE, NEAR_GRADIENT = 0.03, 0.1
"""[m] from surfaces, within which occupancy and gradient are judged."""
POINTS = 20_000
"""Asked about in every scene."""
AHEAD = 10
"""Expert steps from a state to the subgoal that plans are ranked by."""


def diagnose(env_id: str, scenes: int, *, seed: int, weights: Path | None) -> Values:
    """Measure a field in test scenes; every value is the mean over them.

    Args:
        env_id: which environment.
        scenes: how many.
        seed: of the first scene; the others follow.
        weights: folder of the field; None is the package's.

    Returns:
        ``occupancy_iou`` within 3 cm of surfaces; ``gradient_cosine`` within 10 cm;
        ``yaw_invariance``, the largest relative change of a descriptor when scene and point are
        turned and moved together, and ``roll_sensitivity``, the mean one when they are rolled by
        90 degrees; ``transfer_error``, how far in the material a point of the goal is from that
        point of the expert's last state whose descriptor is nearest: 0 is the same point, 1 as far
        as a random one (near 0 unless the goal is of another scene); ``interpolation_error`` of the
        baked field where the object is, in units of descriptors, beside ``step_distance``, that of
        consecutive subgoals; ``kendall_tau``
        between baked and exact costs of MPPI's samples half-way through the expert's solution;
        ``progress_correlation``, Kendall's tau between the descriptor distance to the goal and the
        expert's steps left; ``bake_seconds``.

    Raises:
        IcdError: unknown environment, missing or damaged weights.
    """
    found: list[dict[str, float]] = []
    with field_in_test_scenes(env_id, weights) as (field, env):
        for i in range(scenes):
            observation, _ = env.reset(seed=seed + i)
            episode = env.episode(oracle=True)
            oracle = episode.oracle
            assert oracle is not None
            rng = np.random.default_rng([seed + i])
            solid = BoxUnion(env.task.boxes(oracle.scene))
            found.append(
                _truth(field, observation["scene"], solid, rng)
                | _invariance(field, observation["scene"], rng)
                | _transfer(field, observation, oracle.points[-1], episode.canonical_cloud)
                | _planning(field, observation, oracle, env, rng)
            )
    values: Values = {"scenes": scenes}
    for name in found[0]:
        worst = max if name == "yaw_invariance" else np.mean
        values[name] = float(worst([each[name] for each in found]))
    return values


def _truth(
    field: SceneField, scene: Float32Array, solid: BoxUnion, rng: np.random.Generator
) -> dict[str, float]:
    answers = {}
    fixtures = above_floor(scene, field.config.floor_margin)
    for reach in (NEAR_SURFACE, NEAR_GRADIENT):
        points = rng.choice(fixtures, POINTS)
        points = points + rng.uniform(-reach, reach, points.shape).astype(np.float32)
        truth = supervise(points, solid)
        kept = (np.abs(truth.distance) < reach) & (points[:, 2] > 0.0)
        with torch.no_grad():
            out = field(torch.from_numpy(scene)[None], torch.from_numpy(points[kept])[None])
        answers[reach] = (out, truth.distance[kept], truth.gradient[kept])
    out, distance, _ = answers[NEAR_SURFACE]
    said, inside = out.occupancy[0].numpy() > 0, distance < 0
    iou = np.count_nonzero(said & inside) / np.count_nonzero(said | inside)
    out, _, gradient = answers[NEAR_GRADIENT]
    found = out.gradient[0].numpy()
    cosine = (found * gradient).sum(-1) / np.linalg.norm(found, axis=-1)
    return {"occupancy_iou": float(iou), "gradient_cosine": float(cosine.mean())}


def _invariance(
    field: SceneField, scene: Float32Array, rng: np.random.Generator
) -> dict[str, float]:
    points = rng.choice(scene, 1000) + rng.normal(0.0, 0.05, (1000, 3))
    yaw = Rotation.from_euler("z", rng.uniform(-np.pi, np.pi))
    shift = np.append(rng.uniform(-1.0, 1.0, 2), 0.0)
    roll = Rotation.from_euler("x", np.pi / 2)

    def descriptors(turn: Rotation, move: np.ndarray) -> np.ndarray:
        features = exact_features(field, turn.apply(scene) + move)
        return np.asarray(features(turn.apply(points) + move), np.float64)

    before = descriptors(Rotation.identity(), np.zeros(3))
    size = float(np.sqrt(np.square(before - before.mean(axis=0)).sum(-1).mean()))
    yawed = np.linalg.norm(descriptors(yaw, shift) - before, axis=-1) / size
    rolled = np.linalg.norm(descriptors(roll, np.zeros(3)) - before, axis=-1) / size
    return {"yaw_invariance": float(yawed.max()), "roll_sensitivity": float(rolled.mean())}


def _transfer(
    field: SceneField, observation: Observation, solved: FloatArray, canonical: FloatArray
) -> dict[str, float]:
    wanted = exact_features(field, observation["goal_scene"])(observation["desired_goal"])
    found = exact_features(field, observation["scene"])(solved)
    nearest = cKDTree(found).query(wanted)[1]
    apart = np.linalg.norm(canonical[nearest] - canonical, axis=-1)
    random = np.linalg.norm(canonical[:, None] - canonical, axis=-1)
    return {"transfer_error": float(apart.mean() / random.mean())}


def _planning(
    field: SceneField,
    observation: Observation,
    oracle: Oracle,
    env: ContactEnv[Any],
    rng: np.random.Generator,
) -> dict[str, float]:
    before = perf_counter()
    baked = FieldSpace(field).place(observation).here
    seconds = perf_counter() - before
    exact = exact_features(field, observation["scene"])
    chain = exact(oracle.points[::AHEAD])
    steps = np.sqrt(np.square(np.diff(chain, axis=0)).sum(-1).mean(-1))
    error = np.sqrt(np.square(baked(oracle.points[::AHEAD]) - chain).sum(-1).mean())
    to_goal = np.square(chain - chain[-1]).sum(-1).mean(-1)
    return {
        "interpolation_error": float(error),
        "step_distance": float(np.median(steps)),
        "progress_correlation": float(kendalltau(-np.arange(len(to_goal)), to_goal).statistic),
        "kendall_tau": _ranking(baked, exact, oracle, env, rng),
        "bake_seconds": seconds,
    }


def _ranking(
    baked: Features, exact: Features, oracle: Oracle, env: ContactEnv[Any], rng: np.random.Generator
) -> float:
    """Kendall's tau between the costs of MPPI's samples in both."""
    half = len(oracle.actions) // 2
    for action in oracle.actions[:half]:
        env.step(action)
    episode = env.episode(simulator=True)
    assert episode.simulator is not None
    actions = MPPI(ADAPTIVE, episode.action_scale).sample(rng)
    rollout = episode.simulator.rollout(episode.simulator.snapshot(), actions)
    subgoal = exact(oracle.points[None, min(half + AHEAD, len(oracle.points) - 1)])
    costs = [
        nearest_subgoal_cost(squared_distance(features(rollout.points), subgoal))[~rollout.diverged]
        for features in (baked, exact)
    ]
    return float(kendalltau(*costs).statistic)
