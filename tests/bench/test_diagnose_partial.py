"""``icd-bench diagnose ends`` in a partial view: the source sees what the agent would."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from icd_agent.chain import Placed, Subgoals
from icd_agent.completion import Completion
from icd_agent.diffused import DiffusedSource
from icd_envs.api import Episode, Observation
from tests.bench.making import icd_bench

ENV = "ICDCableRoutingAdaptation-v0"


def test_hidden_points_of_the_object_are_guessed(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Observation] = []
    chain = DiffusedSource.chain

    def recorded(
        self: DiffusedSource,
        episode: Episode,
        observation: Observation,
        space: Placed,
        rng: np.random.Generator,
    ) -> Subgoals:
        shown.append(observation)
        return chain(self, episode, observation, space, rng)

    monkeypatch.setattr(DiffusedSource, "chain", recorded)
    task = ("--env", ENV, "--option", "obs_mode=partial")
    found = icd_bench("diagnose", "ends", *task, "--scenes", 1, "--chains", 1)
    assert found.exit_code == 0, found.stderr
    env: Any = gym.make(ENV, split="test", obs_mode="partial").unwrapped
    observation, _ = env.reset(seed=0)
    completed = Completion(env.episode().canonical_cloud)(observation)["achieved_goal"]
    env.close()
    (given,) = shown
    np.testing.assert_array_equal(given["achieved_goal"], completed)
    assert not np.array_equal(given["achieved_goal"], observation["achieved_goal"])
