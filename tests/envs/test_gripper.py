"""The hand: how its motion is observed, and the spheres that planners take it for."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box
from icd_envs.scenes.gripper import gripper_spheres
from icd_envs.tasks.base import run_expert
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import make

STEPS = 6
UP = np.array([0.0, 0.3, 0.8], dtype=np.float32)
"""An action through free space."""
EDGES = 0.0135
"""[m] by which the hand's edges may stick out of its spheres."""
BULGES = 0.016
"""[m] by which the spheres may stick out of the hand."""


class Rising:
    """An expert that rises for ever."""

    done = False

    def act(self, gripper: np.ndarray, points: np.ndarray) -> np.ndarray:
        return UP


@pytest.fixture(scope="module", params=ENV_IDS)
def env(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    env = make(request.param)
    env.reset(seed=0)
    yield env
    env.close()


def motions(env: ContactEnv[Any]) -> dict[str, np.ndarray]:
    """(STEPS + 1, 6) position and velocity while rising, as observed and as demonstrated."""
    start = env.snapshot()
    observed = [env.restore(start)["observation"]]
    observed += [env.step(UP)[0]["observation"] for _ in range(STEPS)]
    env.restore(start)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    plant = env.task.make_plant(oracle.scene)
    shown = run_expert(env.task, oracle.scene, plant, Rising(), STEPS)
    return {"observed": np.stack(observed), "demonstrated": shown.gripper}


def test_velocity_is_zero_at_the_start_and_soon_that_of_the_command(
    env: ContactEnv[Any],
) -> None:
    step = env.episode().action_scale, env.episode().control_period
    assert step == (0.03, 0.05)
    for motion in motions(env).values():
        velocity = motion[:, 3:]
        np.testing.assert_allclose(velocity[0], 0.0, atol=0.005)
        np.testing.assert_allclose(velocity[-1], UP * 0.03 / 0.05, atol=0.03)
        travelled = np.diff(motion[-3:, :3], axis=0) / 0.05
        np.testing.assert_allclose(velocity[-2:], travelled, atol=0.01)


def test_what_is_demonstrated_is_what_is_observed(env: ContactEnv[Any]) -> None:
    found = motions(env)
    np.testing.assert_array_equal(found["demonstrated"], found["observed"])


def hand(env: ContactEnv[Any]) -> list[Box]:
    """The hand's geoms, about its origin."""
    model = env.model
    body = model.body("gripper").id
    geoms = np.flatnonzero(model.geom_bodyid == body)
    assert len(geoms) == 3
    assert np.all(model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_BOX)
    assert np.all(model.geom_quat[geoms] == [1, 0, 0, 0])
    return [Box(model.geom_pos[i], model.geom_size[i], np.eye(3)) for i in geoms]


def test_spheres_are_the_hand_with_its_edges_rounded(env: ContactEnv[Any]) -> None:
    centres, radii = np.split(gripper_spheres().astype(float), [3], axis=1)
    boxes = hand(env)
    grid = np.array(list(itertools.product(np.linspace(-1, 1, 9), repeat=3)))
    points = np.concatenate([box.center + grid * box.half for box in boxes])
    outside = np.linalg.norm(points[:, None] - centres, axis=-1) - radii[:, 0]
    assert outside.min(axis=1).max() < EDGES
    poles = centres[:, None] + radii[:, None] * np.concatenate([np.eye(3), -np.eye(3)])
    assert BoxUnion(boxes)(poles.reshape(-1, 3)).max() < BULGES
