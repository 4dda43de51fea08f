"""What a sampled future costs: distance to the subgoals ahead, and penetration of the scene."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from icd_envs.api import Float64Array, FloatArray


def squared_distance(points: FloatArray, subgoals: FloatArray) -> FloatArray:
    """Squared distance between corresponding points, summed over D, mean over the N points.

    The square is expanded so that one product of matrices does the work and nothing of size
    (K, H, L, N, D) exists. Both sides are taken relative to the mean subgoal first: without it
    float32 would lose the small distances in the large coordinates. The product is einsum's and
    not BLAS's, whose last bits depend on the number of threads: results must not.

    Args:
        points: (K, H, N, D), clouds in the cost space, e.g. [m] in the world frame.
        subgoals: (L, N, D), in the same space.

    Returns:
        (K, H, L), e.g. [m^2], never negative.
    """
    samples, horizon, count, _ = points.shape
    goals = subgoals.reshape(len(subgoals), -1)
    centre = goals.mean(axis=0)
    # Diverged samples may hold anything: what overflows stays in their own rows.
    with np.errstate(over="ignore", invalid="ignore"):
        states = points.reshape(samples * horizon, -1) - centre
        goals = goals - centre
        squares = -2.0 * np.einsum("ij,lj->il", states, goals)
        squares += np.einsum("ij,ij->i", states, states)[:, None]
        squares += np.einsum("ij,ij->i", goals, goals)
    nonnegative: FloatArray = np.maximum(squares / count, 0.0)
    return nonnegative.reshape(samples, horizon, len(goals))


def nearest_subgoal_cost(distances: FloatArray) -> Float64Array:
    """Sum over time of the squared distance to the nearest of the subgoals given.

    Section "MPPI with Neural Contact Subgoals" of the paper: sum_t min_l d(s_t, g_l). Which
    subgoals take part (all that remain, or a window of the next few) is the caller's choice.

    Args:
        distances: (K, H, L) from ``squared_distance``.

    Returns:
        (K,).
    """
    total: Float64Array = distances.min(axis=-1).sum(axis=-1, dtype=np.float64)
    return total


def collision_cost(
    gripper: FloatArray,
    spheres: FloatArray,
    signed_distance: Callable[[FloatArray], FloatArray],
    weight: float,
) -> Float64Array:
    """Depth to which the gripper's spheres are inside obstacles, summed over spheres and time.

    The paper's lambda_col max(-SDF(r_t), 0), with r_t the gripper's geometry: for a sphere,
    -SDF is its radius minus the signed distance of its centre.

    Args:
        gripper: (K, H, 3) [m], world frame.
        spheres: (S, 4), centre relative to the gripper position [m] and radius [m].
        signed_distance: maps (M, 3) [m] to (M,) [m], negative inside obstacles.
        weight: lambda_col [cost per metre and step].

    Returns:
        (K,).
    """
    samples, horizon, _ = gripper.shape
    if weight == 0.0 or len(spheres) == 0:
        return np.zeros(samples)
    centres = gripper[:, :, None, :] + spheres[:, :3]
    clearance = signed_distance(centres.reshape(-1, 3)).reshape(samples, horizon, len(spheres))
    depth = np.maximum(spheres[:, 3] - clearance, 0.0)
    total: Float64Array = depth.sum(axis=(1, 2), dtype=np.float64)
    return weight * total
