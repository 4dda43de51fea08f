"""The ablation ladder: agents that know the answer, to find out which part of a method fails."""

from __future__ import annotations

import numpy as np

from icd_agent.chain import CostSpace, PointSpace
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker, TrackerConfig
from icd_envs.api import Episode, FloatArray, Observation
from icd_envs.errors import InvalidOptionError

ORACLE_STRIDE = 10
"""Expert steps between subgoals: about one horizon, so that each can be reached in one plan."""


class OracleSource:
    """States of the scripted expert's own solution, every few steps, and its last one."""

    needs_oracle = True

    def __init__(self, space: CostSpace, stride: int = ORACLE_STRIDE) -> None:
        """Measure in ``space``, take every ``stride``-th state."""
        self._space = space
        self._stride = stride

    def chain(self, episode: Episode, observation: Observation) -> FloatArray:
        """Return the expert's states, (L, N, D).

        Raises:
            InvalidOptionError: if the episode has no oracle.
        """
        if episode.oracle is None:
            raise InvalidOptionError(
                "episode.oracle=None: oracle subgoals need the expert's states"
            )
        points = episode.oracle.points
        last = len(points) - 1
        return self._space.features(points[np.unique(np.r_[0 : last : self._stride, last])])


def make_oracle_points() -> SubgoalTracker:
    """Build rung 1: oracle subgoals, distances in points; what fails here is the tracking."""
    space = PointSpace()
    # One at a time: with a window of 3 the tracker skipped the lift over a clip in 2 of 20 scenes.
    config = TrackerConfig(window=1, patience=40)
    return SubgoalTracker(OracleSource(space), space, preset("paper"), config)
