"""Divergence never passes for motion: MuJoCo's own recovery is off, and this looks instead."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import mujoco
import numpy as np

from icd_envs.api import BoolArray, Float64Array

BOUND: Final = 5.0
"""[m] nothing in any task gets this far from the origin unless the physics blew up."""


def diverged(nodes: Float64Array, expected: float, reached: Float64Array) -> BoolArray:
    """Whether positions stopped making sense, or time stopped (MuJoCo gave the rollout up).

    Args:
        nodes: (K, H, P, 3) [m] tracked positions.
        expected: [s] simulation time that the rollout should have reached.
        reached: (K,) [s] simulation time that it reached.

    Returns:
        (K,) booleans.
    """
    wild = ~np.all(np.abs(nodes) < BOUND, axis=(1, 2, 3))  # also true for NaN
    return np.asarray(wild | ~(np.abs(reached - expected) < 1e-6))


@contextmanager
def quiet_mujoco() -> Iterator[None]:
    """Keep MuJoCo's warnings off the console and out of a log file in the working directory.

    They are counted in ``MjData.warning`` all the same. Whatever handler was there comes back:
    dm_control installs one that logs every warning to the console.
    """
    handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(handler)


def _ignore(_message: str) -> None:
    return None
