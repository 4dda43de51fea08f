from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from icd_envs.errors import IncompatibleStateError
from icd_envs.physics.plant import Plant, TrackedCloud
from icd_envs.scenes.cable_routing import CableRoutingScene, build_scene
from icd_envs.tasks.cable_routing import CableRouting
from tests.envs.making import random_actions

TASK = CableRouting()


@pytest.fixture(scope="module")
def scene() -> CableRoutingScene:
    return TASK.draw_scenes(np.random.default_rng(3)).scene


@pytest.fixture(scope="module")
def built(scene: CableRoutingScene) -> tuple[Plant, np.ndarray]:
    plant = TASK.make_plant(scene)
    return plant, plant.get_state()


@pytest.fixture
def plant(built: tuple[Plant, np.ndarray]) -> Plant:
    plant, start = built
    plant.set_state(start)
    return plant


def test_state_comes_back_bit_for_bit_and_so_does_what_follows(plant: Plant) -> None:
    for action in random_actions(0, 5):
        plant.step(action)
    state = plant.get_state()
    futures = []
    for _ in range(2):
        plant.set_state(state)
        assert plant.get_state().tobytes() == state.tobytes()
        for action in random_actions(1, 20):
            plant.step(action)
        futures.append((plant.get_state().tobytes(), plant.points().tobytes()))
    assert futures[0] == futures[1]


def test_looking_changes_nothing(plant: Plant) -> None:
    plant.step(np.ones(3))
    before = plant.get_state()
    plant.nodes(), plant.points(), plant.gripper(), plant.gripper_velocity()
    plant.diverged(), plant.buffer_overflows()
    assert plant.get_state().tobytes() == before.tobytes()


def test_what_is_read_is_a_copy(plant: Plant) -> None:
    before = plant.get_state()
    for read in (plant.nodes, plant.points, plant.gripper, plant.gripper_velocity, plant.get_state):
        read()[...] = 1e9
    assert plant.get_state().tobytes() == before.tobytes()
    assert np.abs(plant.nodes()).max() < 5


def test_positions_belong_to_the_present_state(plant: Plant) -> None:
    for action in random_actions(2, 10):
        plant.step(action)
    nodes = plant.nodes()
    data = mujoco.MjData(plant.model)
    data.qpos[:] = plant.data.qpos
    mujoco.mj_kinematics(plant.model, data)
    np.testing.assert_array_equal(nodes, data.site_xpos[plant.node_sites])


def test_gripper_travels_the_action_scale_per_step(plant: Plant) -> None:
    start = plant.gripper()
    for _ in range(5):
        plant.step(np.array([0.0, 0.0, 1.0]))
    climbed = plant.gripper() - start
    assert climbed[2] == pytest.approx(5 * TASK.action_scale, rel=0.2)
    assert np.abs(climbed[:2]).max() < 0.02


def test_same_scene_has_the_same_id_and_another_scene_another(scene: CableRoutingScene) -> None:
    other = TASK.draw_scenes(np.random.default_rng(4)).scene
    cloud = TrackedCloud(np.array([0]), np.array([[0.0]]))
    ids = [Plant(build_scene(s).to_xml_string(), cloud, 0.03).scene_id for s in (scene, other)]
    assert ids[0] == TASK.make_plant(scene).scene_id
    assert ids[0] != ids[1]


@pytest.mark.parametrize("fault", ["short", "long", "flat", "nan", "infinite"])
def test_unusable_state_is_refused_and_nothing_changes(plant: Plant, fault: str) -> None:
    good = plant.get_state()
    bad = {
        "short": good[:-1],
        "long": np.append(good, 0.0),
        "flat": good[None],
        "nan": np.where(np.arange(len(good)) == 7, np.nan, good),
        "infinite": np.where(np.arange(len(good)) == 7, np.inf, good),
    }[fault]
    with pytest.raises(IncompatibleStateError, match=r"state\.physics"):
        plant.set_state(bad)
    assert plant.get_state().tobytes() == good.tobytes()


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e12])
@pytest.mark.parametrize("where", ["qpos", "qvel"])
def test_divergence_is_seen_without_a_log_file(
    plant: Plant, where: str, value: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert not plant.diverged()
    getattr(plant.data, where)[plant.model.nv // 2] = value
    plant.step(np.zeros(3))
    assert plant.diverged()
    assert list(tmp_path.iterdir()) == []


def test_setting_a_good_state_ends_a_divergence(built: tuple[Plant, np.ndarray]) -> None:
    plant, start = built
    futures = []
    for fault in (False, True):
        plant.set_state(start)
        if fault:
            plant.data.qvel[5] = np.nan
            plant.step(np.zeros(3))
            assert plant.diverged()
            plant.set_state(start)
        for action in random_actions(3, 10):
            plant.step(action)
        assert not plant.diverged()
        futures.append(plant.get_state().tobytes())
    assert futures[0] == futures[1]


def test_cloud_of_a_batch_has_the_bits_of_each_state_alone() -> None:
    rng = np.random.default_rng(0)
    cloud = TrackedCloud(rng.integers(0, 9, 50), rng.uniform(0, 1, (50, 1)))
    nodes = rng.normal(size=(4, 7, 10, 3))
    batch = cloud(nodes)
    assert batch.shape == (4, 7, 50, 3)
    assert batch.dtype == np.float32
    alone = np.array([[cloud(state) for state in row] for row in nodes])
    assert batch.tobytes() == alone.tobytes()


def test_cloud_lies_between_its_nodes() -> None:
    nodes = np.random.default_rng(1).normal(size=(3, 3))
    cloud = TrackedCloud(np.array([0, 0, 1, 1]), np.array([[0.0], [0.5], [0.0], [1.0]]))
    expected = [nodes[0], (nodes[0] + nodes[1]) / 2, nodes[1], nodes[2]]
    np.testing.assert_allclose(cloud(nodes), expected, atol=1e-7)
