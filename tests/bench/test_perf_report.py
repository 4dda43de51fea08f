"""``icd-bench perf``: what it compares is comparable, and its figures are numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import gymnasium as gym
import mujoco
import numpy as np
import pytest
from mujoco import rollout

from benchmarks.perf.naive_cable import LINKS, make_naive
from benchmarks.perf.report import ENV_ID
from icd_envs.api import Float32Array, Float64Array
from icd_envs.physics.plant import SLIDES
from icd_envs.physics.simulator import FULL, RolloutSimulator
from icd_envs.scenes.arena import SUBSTEPS
from icd_envs.tasks.env import ContactEnv
from tests.bench.making import icd_bench

FIGURES = {
    "physics_us_per_step",
    "naive_chain_us_per_step",
    "naive_over_ours",
    "bake_s",
    "descriptors_ms",
    "descriptors_over_bare_rollout",
    "replan_ms",
    "replan_diffusion_ms",
    "replan_over_mppi_step",
    "planner_threads",
    "mppi_step_ms",
    "rollout_ms",
    "cost_ms",
    "update_ms",
    "bare_rollout_ms",
    "step_over_bare_rollout",
}


class Scene(NamedTuple):
    env: ContactEnv[Any]
    simulator: RolloutSimulator
    points: Float32Array
    naive: mujoco.MjModel
    start: Float64Array


@pytest.fixture(scope="module")
def scene() -> Iterator[Scene]:
    """A scene at its start, and the naive cable in it."""
    env: Any = gym.make(ENV_ID, split="test").unwrapped
    observation, _ = env.reset(seed=0)
    points = observation["achieved_goal"]
    episode = env.episode(simulator=True, oracle=True, threads=1)
    yield Scene(env, episode.simulator, points, *make_naive(episode.oracle.scene, points))
    env.close()


def things(model: mujoco.MjModel) -> dict[str, Float64Array]:
    """Place, orientation and size of all that a cable can touch, but for the anchor's knob."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geoms = [model.geom(i) for i in range(model.ngeom)]
    return {
        geom.name: np.concatenate([data.geom_xpos[geom.id], data.geom_xmat[geom.id], geom.size])
        for geom in geoms
        if geom.name.startswith(("floor", "clip_", "palm", "finger_"))
    }


def test_the_naive_cable_lies_where_ours_does_among_the_same_things(scene: Scene) -> None:
    naive, ours = scene.naive, scene.simulator.model
    data = mujoco.MjData(naive)
    mujoco.mj_setState(naive, data, scene.start, FULL)
    mujoco.mj_forward(naive, data)
    nodes = [*(data.body(f"link_{i}").xpos for i in range(LINKS)), data.site("tip").xpos]
    places = np.linspace(0, len(scene.points) - 1, LINKS + 1).round().astype(int)
    np.testing.assert_allclose(nodes, scene.points[places], atol=0.004)
    assert naive.opt.timestep == ours.opt.timestep
    np.testing.assert_array_equal(naive.opt.gravity, ours.opt.gravity)
    assert naive.body_subtreemass[0] == pytest.approx(ours.body_subtreemass[0])
    assert things(naive).keys() == things(ours).keys()
    for part, thing in things(ours).items():
        np.testing.assert_array_equal(things(naive)[part], thing)


def test_the_naive_cable_is_moved_as_ours_is_by_the_same_actions(scene: Scene) -> None:
    actions = np.random.default_rng(0).uniform(-1, 1, (4, 10, 3))
    naive, ours = scene.naive, scene.simulator.model
    speed = scene.env.task.action_scale / (SUBSTEPS * naive.opt.timestep)
    control = np.repeat(actions * speed, SUBSTEPS, axis=1)
    theirs = rollout.rollout(naive, [mujoco.MjData(naive)], scene.start, control)[0]
    trace = scene.simulator.integrate(scene.env.snapshot(), actions).states[:, :-1]
    hand, wanted = (
        states[:, SUBSTEPS - 1 :: SUBSTEPS, [1 + model.joint(slide).qposadr[0] for slide in SLIDES]]
        for states, model in ((theirs, naive), (trace, ours))
    )
    assert np.linalg.norm(wanted[:, -1] - wanted[:, 0], axis=-1).max() > 0.1
    assert np.linalg.norm(hand - wanted, axis=-1).max() < 0.01


@pytest.mark.slow
def test_every_figure_is_measured() -> None:
    measured = icd_bench("perf", "--repeats", 1, "--json")
    assert measured.exit_code == 0, measured.stderr
    figures = json.loads(measured.stdout)
    assert figures.keys() == FIGURES
    assert all(math.isfinite(value) and value > 0 for value in figures.values()), figures
