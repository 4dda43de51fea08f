"""Laws of the field: what it may and may not depend on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from torch import Tensor

from icd_agent.field.config import FieldConfig
from icd_agent.field.field import SceneField
from icd_envs.errors import InvalidOptionError
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.tasks.cable_routing import CableRouting
from icd_envs.tasks.notebook_folding import NotebookFolding

SMALL = FieldConfig(
    anchors=64, channels=8, code_channels=16, edge_width=16, width=32, descriptor=16
)
TASKS = (CableRouting(), NotebookFolding())


@pytest.fixture(scope="module", params=["local", "global"])
def field(request: pytest.FixtureRequest) -> SceneField:
    torch.manual_seed(0)
    return SceneField(replace(SMALL, scope=request.param)).double().eval()


def scene_of(seed: int, points: int = 400) -> Tensor:
    """(1, M, 3) cloud of a random scene of either task."""
    rng = np.random.default_rng(seed)
    task = TASKS[seed % 2]
    boxes = task.boxes(task.draw_scenes(rng).scene)  # type: ignore[arg-type]
    return torch.from_numpy(sample_scene(boxes, points, points // 5, rng)).double()[None]


def queries_of(seed: int, scene: Tensor) -> Tensor:
    rng = np.random.default_rng(seed)
    near = scene[0, rng.integers(scene.shape[1], size=30)].numpy()
    return torch.from_numpy(near + rng.normal(0, 0.05, near.shape))[None]


def moved(points: Tensor, matrix: np.ndarray, shift: np.ndarray) -> Tensor:
    return points @ torch.from_numpy(matrix).T + torch.from_numpy(shift)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**16), yaw=st.floats(-4, 4), x=st.floats(-2, 2), z=st.floats(-1, 1))
def test_yaw_and_place_of_scene_and_point_together_change_nothing_but_the_gradients_frame(
    field: SceneField, seed: int, yaw: float, x: float, z: float
) -> None:
    scene = scene_of(seed)
    points = queries_of(seed, scene)
    matrix, shift = Rotation.from_euler("z", yaw).as_matrix(), np.array([x, -x, z])
    before = field(scene, points)
    after = field(moved(scene, matrix, shift), moved(points, matrix, shift))
    for name in ("descriptor", "occupancy", "log_distance"):
        torch.testing.assert_close(getattr(after, name), getattr(before, name), atol=1e-6, rtol=0)
    turned = moved(before.gradient, matrix, np.zeros(3))
    torch.testing.assert_close(after.gradient, turned, atol=1e-6, rtol=0)


@pytest.mark.parametrize("seed", range(4))
def test_roll_changes_descriptors(field: SceneField, seed: int) -> None:
    scene = scene_of(seed)
    points = queries_of(seed, scene)
    matrix = Rotation.from_euler("x", np.pi / 2).as_matrix()
    before = field(scene, points).descriptor
    after = field(moved(scene, matrix, np.zeros(3)), moved(points, matrix, np.zeros(3))).descriptor
    assert float(((after - before).norm() / before.norm()).detach()) > 0.05


def test_batches_are_single_scenes_and_points_do_not_see_one_another(field: SceneField) -> None:
    scenes = torch.cat([scene_of(0), scene_of(2)])
    points = torch.cat([queries_of(seed, scenes[:1]) for seed in (0, 1)])
    together = field(scenes, points).descriptor
    for b in range(2):
        alone = field(scenes[b : b + 1], points[b : b + 1, 3:9]).descriptor
        torch.testing.assert_close(alone[0], together[b, 3:9])


def test_descriptors_are_continuous(field: SceneField) -> None:
    scene = scene_of(0)
    low, high = scene[0].amin(0), scene[0].amax(0)
    line = low + torch.linspace(0, 1, 20_001, dtype=torch.float64)[:, None] * (high - low)
    descriptors = field(scene, line[None]).descriptor[0].detach()
    jumps = descriptors.diff(dim=0).norm(dim=-1)
    # 0.05 mm apart: nothing may jump where the nearest anchors change.
    assert float(jumps.max()) < 0.02 * float((descriptors - descriptors.mean(0)).norm(dim=-1).max())


def test_a_scene_of_few_points_or_bare_floor_is_answered_with_finite_numbers(
    field: SceneField,
) -> None:
    floor = torch.zeros(1, 50, 3, dtype=torch.float64)
    floor[0, :, 0] = torch.arange(50)
    for scene in (floor, scene_of(0)[:, :3], torch.zeros(1, 10, 3, dtype=torch.float64)):
        out = field(scene, queries_of(0, scene))
        assert all(bool(value.isfinite().all()) for value in out)


def test_one_code_describes_the_whole_scene() -> None:
    torch.manual_seed(0)
    field = SceneField(replace(SMALL, scope="global")).double().eval()
    scene = scene_of(0)
    code = field.encoder(scene)
    assert code.features.shape == (1, 1, 3, SMALL.code_channels)
    far = scene[0, scene[0, :, 0].argmax()]
    changed = scene.clone()
    changed[0, scene[0, :, 2].argmax(), :2] += 0.2
    points = far + torch.zeros(1, 1, 3, dtype=torch.float64)
    # What happens anywhere in the scene changes what is said everywhere.
    assert not torch.allclose(field(changed, points).descriptor, field(scene, points).descriptor)


@pytest.mark.parametrize(
    "wrong", [{"anchors": 0}, {"scope": "locla"}, {"length_scale": 0.0}, {"floor_margin": -1.0}]
)
def test_config_refuses_by_name(wrong: dict[str, object]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(wrong))):
        FieldConfig(**wrong)  # type: ignore[arg-type]
