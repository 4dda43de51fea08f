from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from trimesh.proximity import closest_point_naive

from icd_envs.api import BoolArray, Float64Array
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.boxes import Box

SEEDS = st.integers(0, 2**32 - 1)
STEP = 1e-5


def random_boxes(rng: np.random.Generator, count: int) -> list[Box]:
    rotations = Rotation.random(count, rng=rng).as_matrix()
    centers, halves = rng.uniform(-0.3, 0.3, (count, 3)), rng.uniform(0.01, 0.2, (count, 3))
    return [Box(*parts) for parts in zip(centers, halves, rotations, strict=True)]


def mesh_of(box: Box) -> trimesh.Trimesh:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = box.rotation, box.center
    return trimesh.creation.box(2 * box.half, transform=pose)


def distances(boxes: list[Box], points: Float64Array) -> Float64Array:
    """(B, M) distance from each point to each box's surface, by trimesh."""
    return np.array([closest_point_naive(mesh_of(box), points)[1] for box in boxes])


def within(boxes: list[Box], points: Float64Array) -> BoolArray:
    """(B, M) whether each box holds each point: behind every face of trimesh's convex mesh."""
    found = []
    for mesh in map(mesh_of, boxes):
        to_faces = points[:, None] - mesh.triangles_center
        found.append(np.all(np.sum(to_faces * mesh.face_normals, axis=-1) < 0, axis=1))
    return np.array(found)


def draw(seed: int, count: int) -> tuple[list[Box], Float64Array]:
    rng = np.random.default_rng(seed)
    boxes = random_boxes(rng, count)
    inside = np.concatenate(
        [box.center + rng.uniform(-1, 1, (20, 3)) * box.half @ box.rotation.T for box in boxes]
    )
    return boxes, np.concatenate([rng.uniform(-0.8, 0.8, (60, 3)), inside])


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(1, 4))
def test_distance_outside_is_that_of_trimesh(seed: int, count: int) -> None:
    boxes, points = draw(seed, count)
    outside = ~within(boxes, points).any(axis=0)
    found = BoxUnion(boxes)(points)
    np.testing.assert_allclose(
        found[outside], distances(boxes, points).min(axis=0)[outside], atol=1e-7
    )


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_depth_inside_one_box_is_that_of_trimesh(seed: int) -> None:
    boxes, points = draw(seed, 1)
    inside = within(boxes, points)[0]
    assert inside.any()
    found = BoxUnion(boxes)(points)
    np.testing.assert_allclose(-found[inside], distances(boxes, points)[0, inside], atol=1e-7)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(1, 4))
def test_sign_says_whether_a_point_is_inside(seed: int, count: int) -> None:
    boxes, points = draw(seed, count)
    clear = distances(boxes, points).min(axis=0) > 1e-9
    inside = within(boxes, points).any(axis=0)
    assert inside.any()
    np.testing.assert_array_equal((BoxUnion(boxes)(points) < 0)[clear], inside[clear])


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(1, 4))
def test_nearby_points_have_nearby_distances(seed: int, count: int) -> None:
    boxes, points = draw(seed, count)
    union = BoxUnion(boxes)
    found, shuffled = union(points), np.random.default_rng(seed).permutation(len(points))
    apart = np.linalg.norm(points - points[shuffled], axis=-1)
    assert np.all(np.abs(found - found[shuffled]) <= apart + 1e-12)


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(1, 4))
def test_gradient_outside_has_norm_one(seed: int, count: int) -> None:
    boxes, points = draw(seed, count)
    union = BoxUnion(boxes)
    # Where two boxes are equally near the distance has a kink.
    each = np.sort(np.array([BoxUnion([box])(points) for box in boxes]), axis=0)
    smooth = (each[0] > 1e-2) & ((each[1] - each[0] > 1e-3) if count > 1 else True)
    points = points[smooth]
    slopes = [(union(points + d) - union(points - d)) / (2 * STEP) for d in STEP * np.eye(3)]
    np.testing.assert_allclose(np.linalg.norm(slopes, axis=0), 1.0, atol=1e-4)


def test_each_point_has_the_distance_it_has_alone() -> None:
    boxes, points = draw(5, 3)
    union = BoxUnion(boxes)
    alone = np.concatenate([union(point[None]) for point in points])
    np.testing.assert_allclose(union(points), alone, rtol=0, atol=1e-15)


def test_float32_points_give_float64_distances() -> None:
    boxes, points = draw(6, 2)
    found = BoxUnion(boxes)(points.astype(np.float32))
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, BoxUnion(boxes)(points), atol=1e-6)


@pytest.mark.parametrize("count", [1, 3])
def test_no_points_give_no_distances(count: int) -> None:
    boxes = random_boxes(np.random.default_rng(0), count)
    assert BoxUnion(boxes)(np.empty((0, 3))).shape == (0,)


@pytest.mark.parametrize("seed", range(4))
def test_gradient_is_the_derivative_of_the_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    union, points, step = BoxUnion(random_boxes(rng, 4)), rng.uniform(-0.6, 0.6, (3000, 3)), 1e-6
    slopes = [(union(points + e) - union(points - e)) / (2 * step) for e in step * np.eye(3)]
    gradient = union.gradient(points)
    np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1.0, atol=1e-12)
    agree = np.abs(np.stack(slopes, axis=1) - gradient).max(axis=1) < 1e-4
    assert agree.mean() > 0.998  # the rest lie on a kink
