"""Wrappers around any environment that observes point clouds; importing them loads no MuJoCo."""

from __future__ import annotations

from icd_envs.wrappers.flatten import FlattenPointCloud
from icd_envs.wrappers.mismatch import MismatchedPlanner
from icd_envs.wrappers.noise import NoisyActions, NoisyObservations
from icd_envs.wrappers.subsample import SubsamplePointCloud
from icd_envs.wrappers.video import RecordEpisodes

__all__ = [
    "FlattenPointCloud",
    "MismatchedPlanner",
    "NoisyActions",
    "NoisyObservations",
    "RecordEpisodes",
    "SubsamplePointCloud",
]
