from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from icd_agent.mppi.costs import collision_cost, nearest_subgoal_cost, squared_distance
from icd_envs.api import Float64Array, FloatArray


def naive_squared_distance(points: FloatArray, subgoals: FloatArray) -> Float64Array:
    points, subgoals = points.astype(np.float64), subgoals.astype(np.float64)
    out = np.zeros((*points.shape[:2], len(subgoals)))
    for k, h, g in np.ndindex(out.shape):
        out[k, h, g] = np.mean(
            [np.sum((a - b) ** 2) for a, b in zip(points[k, h], subgoals[g], strict=True)]
        )
    return out


@pytest.mark.parametrize("dim", [1, 3, 7])
def test_squared_distance_equals_a_naive_loop(dim: int) -> None:
    rng = np.random.default_rng(dim)
    points, subgoals = rng.normal(size=(3, 2, 5, dim)), rng.normal(size=(4, 5, dim))
    np.testing.assert_allclose(
        squared_distance(points, subgoals), naive_squared_distance(points, subgoals), rtol=1e-12
    )


def test_float32_keeps_a_millimetre_far_from_the_origin() -> None:
    rng = np.random.default_rng(0)
    subgoals = rng.uniform(-0.3, 0.3, (4, 50, 3)) + 1.0
    points = subgoals[None, :2] + rng.normal(0.0, 0.001, (3, 2, 50, 3))
    points, subgoals = points.astype(np.float32), subgoals.astype(np.float32)
    result = squared_distance(points, subgoals)
    assert result.dtype == np.float32
    np.testing.assert_allclose(result, naive_squared_distance(points, subgoals), atol=1e-7)


def test_squared_distance_to_itself_is_not_negative() -> None:
    cloud = np.random.default_rng(1).uniform(0, 1, (2, 3, 200, 3)).astype(np.float32)
    result = squared_distance(cloud, cloud[0])
    assert (result >= 0).all()
    np.testing.assert_allclose(np.diagonal(result[0]), 0.0, atol=1e-6)


def test_void_sample_spoils_only_itself() -> None:
    rng = np.random.default_rng(2)
    points, subgoals = rng.normal(size=(3, 2, 5, 3)).astype(np.float32), rng.normal(size=(4, 5, 3))
    clean = squared_distance(points, subgoals.astype(np.float32))
    points[1] = 1e30
    spoilt = squared_distance(points, subgoals.astype(np.float32))
    np.testing.assert_array_equal(spoilt[[0, 2]], clean[[0, 2]])
    assert not np.isfinite(spoilt[1]).any()


def test_bits_do_not_depend_on_the_number_of_blas_threads() -> None:
    program = (
        "import hashlib, numpy as np; from icd_agent.mppi.costs import squared_distance as f;"
        "r = np.random.default_rng(0); p = r.normal(size=(80, 10, 200, 3)).astype('f4');"
        "g = r.normal(size=(30, 200, 3)).astype('f4');"
        "print(hashlib.sha256(f(p, g).tobytes()).hexdigest())"
    )
    digests = set()
    for threads in ("1", "2"):
        env = os.environ | {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads}
        run = subprocess.run(
            [sys.executable, "-c", program], env=env, capture_output=True, text=True, check=True
        )
        digests.add(run.stdout)
    assert len(digests) == 1


def test_nearest_subgoal_cost_sums_the_minimum_over_time() -> None:
    distances = np.array([[[3.0, 1.0], [2.0, 5.0]], [[0.0, 9.0], [9.0, 4.0]]])
    np.testing.assert_array_equal(nearest_subgoal_cost(distances), [3.0, 4.0])


def unit_ball(points: FloatArray) -> Float64Array:
    distance: Float64Array = np.linalg.norm(points, axis=1)
    return distance - 1.0


def test_collision_cost_equals_a_naive_loop() -> None:
    rng = np.random.default_rng(3)
    gripper, spheres = rng.normal(size=(4, 3, 3)), rng.uniform(0.0, 0.3, size=(5, 4))
    expected = np.zeros(4)
    for k, h, s in np.ndindex(4, 3, 5):
        centre = gripper[k, h] + spheres[s, :3]
        expected[k] += 2.0 * max(spheres[s, 3] - (np.linalg.norm(centre) - 1.0), 0.0)
    np.testing.assert_allclose(collision_cost(gripper, spheres, unit_ball, 2.0), expected)


def test_touching_costs_nothing_and_depth_costs_its_weight() -> None:
    spheres = np.array([[0.0, 0.0, 0.0, 0.5]])
    gripper = np.array([[[1.5, 0.0, 0.0]], [[1.25, 0.0, 0.0]]])
    np.testing.assert_allclose(collision_cost(gripper, spheres, unit_ball, 8.0), [0.0, 2.0])


@pytest.mark.parametrize(("spheres", "weight"), [(np.zeros((0, 4)), 1.0), (np.ones((2, 4)), 0.0)])
def test_nothing_to_check_asks_for_no_distance(spheres: Float64Array, weight: float) -> None:
    def never(points: FloatArray) -> Float64Array:
        raise AssertionError("signed_distance was called")

    costs = collision_cost(np.zeros((4, 3, 3)), spheres, never, weight)
    np.testing.assert_array_equal(costs, np.zeros(4))
