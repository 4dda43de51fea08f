"""When a source is asked for another chain, to the act."""

from __future__ import annotations

import numpy as np

from icd_agent.chain import Placed, PointSpace, Subgoals
from icd_agent.mppi.presets import PAPER
from icd_agent.tracking import SubgoalTracker, TrackerConfig
from icd_envs.api import Episode, Observation
from tests.agent.toy_world import ToyWorld, cloud_at

FAR = cloud_at(np.array([(9.0, 0.0, 0.0)]))


class Recorded:
    """Keeps its chain, and the numbers of the acts at which it was asked; the first is 1."""

    needs_oracle = False

    def __init__(self) -> None:
        self.act = 0
        self.asked: list[int] = []

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        self.asked.append(self.act)
        return Subgoals(FAR, FAR)

    def again(
        self,
        episode: Episode,
        observation: Observation,
        space: Placed,
        rng: np.random.Generator,
        index: int | None,
    ) -> None:
        self.asked.append(self.act)


def asked(acts: int, *, patience: int | None, replan_every: int) -> list[int]:
    source, world = Recorded(), ToyWorld()
    config = TrackerConfig(patience=patience, replan_every=replan_every)
    tracker = SubgoalTracker(source, PointSpace(), PAPER, config)
    tracker.reset(world.episode(), 0)
    for source.act in range(1, acts + 1):
        world.step(tracker.act(world.observation()))
    return source.asked


def test_twenty_acts_after_the_first_chain_and_then_at_every_twenty_first() -> None:
    assert asked(85, patience=None, replan_every=20) == [1, 21, 42, 63, 84]


def test_a_question_because_patience_ran_out_starts_the_count_anew() -> None:
    assert asked(20, patience=None, replan_every=4) == [1, 5, 10, 15, 20]
    stalled = asked(20, patience=7, replan_every=100)
    assert len(stalled) > 1
    between = asked(20, patience=7, replan_every=5)
    again = stalled[1]
    assert again in between
    assert between[between.index(again) + 1] == min(again + 6, stalled[2])
