"""``icd-bench diagnose ends`` in a partial view: the source sees what the agent would."""

from __future__ import annotations

import numpy as np
import pytest

from icd_agent.chain import Placed, Subgoals
from icd_agent.diffused import DiffusedSource
from icd_envs.api import Episode, Observation
from tests.bench.test_cli import icd_bench


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
    task = ("--env", "ICDCableRoutingAdaptation-v0", "--option", "obs_mode=partial")
    found = icd_bench("diagnose", "ends", *task, "--scenes", 1, "--chains", 1)
    assert found.exit_code == 0, found.stderr
    (observation,) = shown
    hidden = np.asarray(observation["achieved_goal_mask"]) == 0  # type: ignore[typeddict-item]
    assert hidden.any()
    cloud = observation["achieved_goal"]
    apart = np.linalg.norm(cloud[hidden][:, None] - cloud[~hidden][None], axis=-1).min(axis=1)
    assert apart.max() < 0.3  # near the rest, not at (0, 0, 0)
