"""Interpolation of a field whose answer is known: a linear function, which it repeats exactly."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from icd_agent.field.baked import BakeConfig, BakedField
from icd_agent.field.config import FieldConfig
from icd_agent.field.field import FieldOutput, SceneField
from icd_envs.errors import InvalidOptionError
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.tasks.cable_routing import CableRouting

SLOPES = torch.tensor([[1.0, -2.0], [0.5, 3.0], [2.0, 1.0]])


class KnownField:
    """Answers every query with a function of the place alone."""

    config = FieldConfig(descriptor=2)

    def __init__(self, *, bent: bool = False) -> None:
        self.asked = 0
        self.bent = bent

    def encoder(self, scene: Tensor) -> None:
        assert scene.shape[0] == 1

    def query(self, code: None, points: Tensor) -> FieldOutput:
        self.asked += points.shape[1]
        found = points @ SLOPES
        if self.bent:
            found = torch.sin(20.0 * found)
        return FieldOutput(found, found[..., 0], points, found[..., 1])


@pytest.fixture(scope="module")
def scene() -> np.ndarray:
    rng = np.random.default_rng(0)
    task = CableRouting()
    return sample_scene(task.boxes(task.draw_scenes(rng).scene), 1000, 200, rng)


def bake(field: KnownField | SceneField, scene: np.ndarray, **config: float) -> BakedField:
    place = np.array([[1.0, 0.0, 0.4], [-0.3, -1.0, 0.02]])
    return BakedField(field, scene, place, BakeConfig(**config))


def points_in(scene: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    low, high = scene.min(axis=0) - 0.2, scene.max(axis=0) + 0.2
    low[2] = 0.0
    return np.random.default_rng(seed).uniform(low, high, (count, 3)).astype(np.float32)


def test_linear_functions_are_repeated_at_any_place(scene: np.ndarray) -> None:
    baked = bake(KnownField(), scene)
    points = points_in(scene, 400).reshape(4, 20, 5, 3)
    found = baked.features(points)
    assert found.shape == (4, 20, 5, 2)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, points @ SLOPES.numpy(), atol=2e-5)


def test_fixtures_are_looked_at_more_closely(scene: np.ndarray) -> None:
    field = KnownField(bent=True)
    baked = bake(field, scene)
    assert field.asked == baked.evaluated
    near = scene[scene[:, 2] > 0.01][::10]
    far = points_in(scene, 400)
    gap = np.linalg.norm(far[:, None] - near[None], axis=-1).min(axis=1)
    error = {}
    for name, points in (("near", near), ("far", far[gap > 0.1])):
        truth = field.query(None, torch.from_numpy(points)[None]).descriptor[0].numpy()
        error[name] = np.abs(baked.features(points) - truth).mean()
    assert error["near"] < 0.3 * error["far"]


def test_finer_grids_are_closer_to_the_truth(scene: np.ndarray) -> None:
    points, errors = points_in(scene, 300), []
    for coarse in (0.06, 0.03, 0.015):
        field = KnownField(bent=True)
        truth = field.query(None, torch.from_numpy(points)[None]).descriptor[0].numpy()
        found = bake(field, scene, coarse=coarse, reach=0.1).features(points)
        errors.append(float(np.abs(found - truth).mean()))
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_what_is_outside_or_not_finite_is_answered_with_finite_numbers(scene: np.ndarray) -> None:
    baked = bake(KnownField(), scene)
    wild = np.array([[50.0, -50.0, 9.0], [np.nan, 0.0, 0.0], [np.inf, -np.inf, 1e38]])
    assert np.all(np.isfinite(baked.features(wild)))
    edge = baked.features(np.array([[50.0, 0.0, 0.1], [80.0, 0.0, 0.1]]))
    np.testing.assert_array_equal(edge[0], edge[1])


def test_bare_floor_needs_no_fine_grid() -> None:
    floor = np.zeros((30, 3), np.float32)
    floor[:, 0] = np.linspace(0, 1, 30)
    baked = bake(KnownField(), floor)
    np.testing.assert_allclose(baked.features(floor), floor @ SLOPES.numpy(), atol=2e-5)


def test_a_real_field_is_repeated_closely(scene: np.ndarray) -> None:
    torch.manual_seed(0)
    field = SceneField(FieldConfig(anchors=32, channels=4, edge_width=8, width=16)).eval()
    baked = bake(field, scene, coarse=0.06, fine=0.02, reach=0.05)
    points = points_in(scene, 200)
    with torch.no_grad():
        code = field.encoder(torch.from_numpy(scene)[None])
        exact = field.query(code, torch.from_numpy(points)[None]).descriptor[0].numpy()
    error = np.abs(baked.features(points) - exact).mean()
    assert error < 0.2 * np.abs(exact - exact.mean(axis=0)).mean()


@pytest.mark.parametrize("name", ["fine", "coarse", "near", "reach"])
def test_config_refuses_by_name(name: str) -> None:
    with pytest.raises(InvalidOptionError, match=name):
        BakeConfig(**{name: 0.0})
