"""A sample that tells no places costs infinitely much, whatever a cost space makes of NaN."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from icd_agent.chain import GoalSource, Placed
from icd_agent.mppi.presets import PAPER
from icd_agent.tracking import SubgoalTracker
from icd_envs.api import FloatArray, Observation, Rollout, SimState
from tests.agent.toy_world import ToyWorld


class Forgiving:
    """Takes NaN for the origin, as a baked field does."""

    def place(self, observation: Observation, *, foreign: bool = False) -> Placed:
        return Placed(np.nan_to_num, np.nan_to_num)


class Broken(ToyWorld):
    """Some samples have a place that is no number, without being called diverged."""

    def __init__(self, part: str, value: float) -> None:
        super().__init__(goal=(0.0, 0.0, 0.0))  # where NaN is taken to be
        self.part, self.value = part, value

    def rollout(self, state: SimState, actions: FloatArray) -> Rollout:
        found = super().rollout(state, actions)
        places = getattr(found, self.part).copy()
        places[3:20, -1, ..., 1] = self.value
        return dataclasses.replace(found, **{self.part: places})


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("part", ["points", "gripper"])
def test_samples_without_places_have_no_weight(part: str, value: float) -> None:
    world = Broken(part, value)
    tracker = SubgoalTracker(GoalSource(), Forgiving(), PAPER)
    tracker.reset(world.episode(), seed=0)
    with np.errstate(invalid="ignore"):
        action = tracker.act(world.observation())
    assert np.isfinite(action).all()
    info = tracker.plan_info
    assert info is not None
    assert info.invalid_samples == 17
    assert np.isinf(info.costs[3:20]).all()
    assert np.isfinite(np.delete(info.costs, np.s_[3:20])).all()
