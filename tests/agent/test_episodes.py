"""Episodes whose physics diverged teach nothing: no network, and no limits."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest
import torch

from icd_agent.episodes import sound_episodes
from icd_agent.field.data import FieldData
from icd_agent.policy.data import PolicyData
from icd_agent.policy.look import Look
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError
from tests.agent.policy.toy import POINTS, toy_demonstrations
from tests.demonstrations.making import make_folder


def policy_data(recorded: object) -> PolicyData:
    look = Look(POINTS, None)
    return PolicyData(recorded, look, POINTS, episodes=6, solved_only=False)  # type: ignore[arg-type]


def test_sound_ones_are_those_of_the_first_that_did_not_diverge() -> None:
    recorded = toy_demonstrations()
    recorded.diverged[[0, 4]] = True
    assert sound_episodes(recorded, 5).tolist() == [1, 2, 3]
    assert sound_episodes(recorded, 100).tolist() == [1, 2, 3, 5]
    with pytest.raises(DemonstrationsError, match="all of the first 1 episodes"):
        sound_episodes(recorded, 1)


def test_a_policy_sees_nothing_of_a_diverged_episode_and_its_limits_neither() -> None:
    recorded = toy_demonstrations()
    without = policy_data(recorded).limits
    rows = slice(recorded.first_state[2], recorded.first_state[3])
    recorded.diverged[2] = True
    recorded.nodes[rows] += 1e6
    recorded.gripper[rows] -= 1e6
    found = policy_data(recorded)
    assert found.episodes == 5
    seen, _ = found.draw(500, np.random.default_rng(0))
    for part in (seen.gripper, seen.object, seen.goal):
        assert part.abs().max() < 10
    for limit, other in zip(found.limits, without, strict=True):
        assert (limit - other).abs().max() < 1


def test_limits_of_the_others_are_those_of_the_whole_folder() -> None:
    recorded = toy_demonstrations()
    low, high = policy_data(recorded).limits
    few = PolicyData(recorded, Look(POINTS, None), POINTS, episodes=6, solved_only=True)
    places = np.concatenate([recorded.nodes.reshape(-1, 3), recorded.gripper[:, :3]])
    assert torch.equal(few.limits[0], low)
    assert torch.equal(few.limits[1], high)
    assert (low.numpy() <= places).all()
    assert (high.numpy() >= places).all()


def test_places_that_never_differ_leave_room_between_the_limits() -> None:
    recorded = toy_demonstrations()
    flat = [recorded.nodes, recorded.gripper]
    clouds = [recorded.scene(i).cloud for i in range(6)]
    for array in (*flat, *clouds):
        array[..., 2] = 0.25
    low, high = policy_data(recorded).limits
    assert (low[2], high[2]) == (-0.25, 0.75)
    assert low.dtype == high.dtype == torch.float32


def test_a_field_asks_about_no_place_of_a_diverged_episode(tmp_path: Path) -> None:
    demonstrations = Demonstrations(make_folder(tmp_path / "data"))
    whole = FieldData.from_demonstrations(demonstrations, 3)
    second = copy.copy(demonstrations)
    second.diverged = np.array([False, True, False])
    left = FieldData.from_demonstrations(second, 3)
    assert (len(whole), len(left)) == (3, 2)
    assert np.array_equal(left._scenes[1].object_points, whole._scenes[2].object_points)
