"""The ablation ladder: agents that know the answer, to find out which part of a method fails."""

from __future__ import annotations

from typing import Literal

import numpy as np

from icd_agent.chain import CostSpace, PointSpace, Subgoals
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker, TrackerConfig
from icd_envs.api import Episode, Observation
from icd_envs.errors import InvalidOptionError

ORACLE_STRIDE = 10
"""Expert steps between subgoals: about one horizon, so that each can be reached in one plan."""


class OracleSource:
    """States of the scripted expert's own solution, every few steps, and its last one."""

    needs_oracle = True

    def __init__(
        self,
        space: CostSpace,
        scene: Literal["present", "goal"] = "present",
        stride: int = ORACLE_STRIDE,
    ) -> None:
        """Choose a solution.

        Args:
            space: where distances are measured.
            scene: the solution of the present scene, or of the one the goal was specified in;
                they differ in the adaptation tasks only.
            stride: every so many states.
        """
        self._space = space
        self._scene = scene
        self._stride = stride

    def chain(self, episode: Episode, observation: Observation) -> Subgoals:
        """Return the expert's states.

        Raises:
            InvalidOptionError: if the episode has no oracle.
        """
        oracle = episode.oracle if self._scene == "present" else episode.goal_oracle
        if oracle is None:
            raise InvalidOptionError(
                "the episode has no oracle, but oracle subgoals need the expert's states: "
                "build it with oracle=True"
            )
        last = len(oracle.points) - 1
        clouds = oracle.points[np.unique(np.r_[0 : last : self._stride, last])]
        return Subgoals(self._space.features(clouds), clouds)


def make_oracle_points() -> SubgoalTracker:
    """Build rung 1: oracle subgoals, distances in points; what fails here is the tracking."""
    return _track_points("present")


def make_transferred_points() -> SubgoalTracker:
    """Build the control of the adaptation tasks: the same with the solution of the goal's scene.

    It knows where everything was, so what it lacks is that contacts matter, not places.
    """
    return _track_points("goal")


def _track_points(scene: Literal["present", "goal"]) -> SubgoalTracker:
    space = PointSpace()
    # One at a time: with a window of 3 the tracker skipped the lift over a clip in 2 of 20 scenes.
    config = TrackerConfig(window=1, patience=40)
    return SubgoalTracker(OracleSource(space, scene), space, preset("paper"), config)
