from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

from icd_envs.physics.plant import Plant
from icd_envs.scenes.arena import make_arena
from icd_envs.scenes.cable import DEFAULT_CABLE, CableSpec, add_cable
from icd_envs.tasks.cable_routing import CableRouting
from tests.envs.making import random_actions

SPECS = [DEFAULT_CABLE, CableSpec(length=0.6, radius=0.003, links=9, density=0.03)]

MAY_TOUCH = {
    frozenset({"cable", "clip"}),
    frozenset({"cable_floor", "floor"}),
    frozenset({"gripper", "clip"}),
}


def kind(geom: str) -> str:
    """The layer a geom of the cable routing scene should be in, by its name."""
    for prefix in ("cable_floor", "cable", "clip", "floor", "anchor"):
        if geom.startswith(prefix):
            return prefix
    assert geom.startswith(("palm", "finger")), geom
    return "gripper"


def compile_cable(spec: CableSpec, yaw: float) -> mujoco.MjModel:
    root = make_arena("cable")
    add_cable(root, spec, np.array([0.1, 0.2, 0.5]), yaw)
    return mujoco.MjModel.from_xml_string(root.to_xml_string())


@pytest.fixture(scope="module")
def plant() -> Plant:
    task = CableRouting()
    return task.make_plant(task.draw_scenes(np.random.default_rng(0)).scene)


@pytest.mark.parametrize("spec", SPECS)
def test_mass_is_density_times_length(spec: CableSpec) -> None:
    model = compile_cable(spec, 0.0)
    assert model.body_mass.sum() == pytest.approx(spec.density * spec.length)
    np.testing.assert_allclose(model.body_mass[1:], spec.density * spec.length / spec.links)


@pytest.mark.parametrize("spec", SPECS)
def test_nodes_are_evenly_spaced_along_its_direction(spec: CableSpec) -> None:
    yaw = 0.7
    model = compile_cable(spec, yaw)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    nodes = np.array([data.site(f"node_{i}").xpos for i in range(spec.links + 1)])
    along = np.linspace(0.0, spec.length, spec.links + 1)
    direction = [np.cos(yaw), np.sin(yaw), 0.0]
    np.testing.assert_allclose(
        nodes, np.add([0.1, 0.2, 0.5], np.outer(along, direction)), atol=1e-9
    )
    np.testing.assert_allclose(data.sensordata.reshape(-1, 3), nodes, atol=1e-12)
    assert [model.sensor(i).name for i in range(model.nsensor)] == [
        f"node_{i}" for i in range(spec.links + 1)
    ]


def test_links_keep_their_length_and_the_ends_hold(plant: Plant) -> None:
    start = plant.get_state()
    anchor = plant.nodes()[0]
    step = DEFAULT_CABLE.length / DEFAULT_CABLE.links
    for action in random_actions(1, 60):
        plant.step(action)
        nodes = plant.nodes()
        np.testing.assert_allclose(
            np.linalg.norm(np.diff(nodes, axis=0), axis=1), step, rtol=0, atol=1e-9
        )
        np.testing.assert_allclose(nodes[0], anchor, atol=1e-9)
        assert np.linalg.norm(nodes[-1] - plant.gripper()) < 0.02  # a taut pull
    plant.set_state(start)


def test_cloud_runs_evenly_from_the_anchor_to_the_gripper(plant: Plant) -> None:
    points, nodes = plant.points(), plant.nodes()
    np.testing.assert_allclose(points[[0, -1]], nodes[[0, -1]], atol=1e-6)
    spacing = np.linalg.norm(np.diff(points, axis=0), axis=1)
    # The chord across a node is shorter than the way along the cable.
    assert spacing.max() < DEFAULT_CABLE.length / (len(points) - 1) + 1e-6
    assert spacing.sum() == pytest.approx(DEFAULT_CABLE.length, rel=0.01)


def test_only_the_layers_that_should_touch_can(plant: Plant) -> None:
    model = plant.model
    kinds = [kind(model.geom(i).name) for i in range(model.ngeom)]
    able = set()
    for i, j in itertools.combinations(range(model.ngeom), 2):
        one, two = model.geom(i), model.geom(j)
        if one.contype[0] & two.conaffinity[0] or two.contype[0] & one.conaffinity[0]:
            able.add(frozenset({kinds[i], kinds[j]}))
    assert able == MAY_TOUCH
    assert set(kinds) == {"cable", "cable_floor", "clip", "floor", "anchor", "gripper"}


def test_free_cable_falls_and_comes_to_rest_on_the_floor() -> None:
    model = compile_cable(DEFAULT_CABLE, 0.0)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 2000)
    tip = data.site(f"node_{DEFAULT_CABLE.links}").xpos
    assert tip[2] == pytest.approx(DEFAULT_CABLE.radius, abs=0.003)
    assert np.abs(data.qvel).max() < 0.5
