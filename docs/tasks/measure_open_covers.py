"""How far open a notebook may be and count as folded: python -m docs.tasks.measure_open_covers.

Prints two tables of docs/tasks/notebook-folding.md (about a minute on one core): the distance to
the goal of a notebook whose free cover lies where the goal has it while the spine is opened, and
the ends of episodes in which the expert's actions are repeated until success begins and nothing is
done from then on.
"""

from __future__ import annotations

import argparse

import gymnasium as gym
import mujoco
import numpy as np

from docs.tasks.render_threshold import distance
from icd_envs.api import Float64Array, FloatArray
from icd_envs.geometry.folding import COLUMNS, FOLDED, ROWS, cover_gap, on_top
from icd_envs.physics.plant import Plant
from icd_envs.tasks.base import run_expert
from icd_envs.tasks.env import ContactEnv
from icd_envs.tasks.notebook_folding import GOAL_DISTANCE, NotebookFolding
from icd_envs.tasks.problem import scene_rng

ANGLES = (15, 30, 45, 60, 77, 80, 90, 180)
"""[degrees] by which the spine is opened."""
SPINE = ("bend_3", "bend_4", "bend_5")
COVER = 9
"""Columns of points on either cover; the other two are on the spine."""


def opened(plant: Plant, angle: float) -> Float64Array:
    """Cloud (N, 3) [m] of a folded notebook, opened by an angle [rad] at its three spine hinges.

    Args:
        plant: with the folded notebook, which stays folded.
        angle: shared evenly; the free cover stays where it is.
    """
    folded, state = plant.points(), plant.get_state()
    for name in SPINE:
        hinge = plant.data.joint(name).qpos
        hinge -= np.sign(hinge) * angle / len(SPINE)
    mujoco.mj_kinematics(plant.model, plant.data)
    cloud = plant.points()
    plant.set_state(state)
    free = slice(-COVER * ROWS, None)
    return moved(cloud, cloud[free], folded[free])


def moved(cloud: FloatArray, here: FloatArray, there: FloatArray) -> Float64Array:
    """A cloud (N, 3) [m] after the rigid motion that best brings points (n, 3) from here to there.

    W. Kabsch, A solution for the best rotation to relate two sets of vectors, 1976.
    """
    a, b = here.astype(np.float64), there.astype(np.float64)
    left, _, right = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return (cloud - a.mean(0)) @ left @ right + b.mean(0)


def between(points: FloatArray) -> float:
    """Angle [degrees] between the covers, from edge to spine, of a cloud (N, 3) [m]."""
    row = points.reshape(COLUMNS, ROWS, 3).mean(axis=1)
    held, free = row[0] - row[COVER - 1], row[-1] - row[-COVER]
    cosine = held @ free / (np.linalg.norm(held) * np.linalg.norm(free))
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def measure_opened(scenes: int) -> None:
    """Angle between the covers and mean distance to the goal, medians of the scenes."""
    task, found = NotebookFolding(), []
    for seed in range(scenes):
        scene = task.draw_scenes(scene_rng("train", seed)).scene
        plant = task.make_plant(scene)
        if run_expert(task, scene, plant, task.make_expert(scene)).success:
            goal = plant.points()
            clouds = [opened(plant, np.radians(angle)) for angle in ANGLES]
            found.append([(distance(cloud, goal), between(cloud)) for cloud in clouds])
    for angle, (far, apart) in zip(ANGLES, np.transpose(found, (1, 2, 0)), strict=True):
        print(f"| {angle} | {np.median(apart):.0f} | {np.median(far):.4f} |")


def measure_early_stops(scenes: int) -> None:
    """How episodes end in which nothing is done once success has begun."""
    env = gym.make(NotebookFolding.env_id)
    assert isinstance(env.unwrapped, ContactEnv)
    angles, distances, folded = [], [], 0
    for seed in range(scenes):
        observation, info = env.reset(seed=seed)
        oracle = env.unwrapped.episode(oracle=True).oracle
        assert oracle is not None
        way, begun, ended = iter(oracle.actions), False, False
        while not ended:
            action = np.zeros(3) if begun else next(way)
            observation, _, terminated, truncated, info = env.step(action)
            begun, ended = begun or info["is_success"], terminated or truncated
        if info["is_success"]:
            cloud = observation["achieved_goal"]
            folded += bool(cover_gap(cloud) < FOLDED and on_top(cloud, info["table"]))
            angles.append(between(cloud))
            distances.append(distance(cloud, observation["desired_goal"]))
    print(
        f"{len(angles)} of {scenes} end with success, {folded} of these as the adaptation asks; "
        f"angle 0/50/100 %: {np.percentile(angles, [0, 50, 100]).round()}, "
        f"distance: {np.percentile(distances, [0, 50, 100]).round(3)}, below {GOAL_DISTANCE}"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=60)
    options = parser.parse_args()
    measure_opened(options.scenes)
    measure_early_stops(options.scenes)
