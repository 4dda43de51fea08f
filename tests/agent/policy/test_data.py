"""Windows: what was seen then, and what was done next."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from icd_agent.episodes import FOREIGN
from icd_agent.policy.data import PolicyData
from icd_agent.policy.look import Look
from icd_envs.errors import InvalidOptionError
from tests.agent.policy.toy import POINTS, STRIDE, toy_demonstrations

RECORDED = toy_demonstrations()


def data(*, solved_only: bool = False, episodes: int = 6) -> PolicyData:
    look = Look(POINTS, None)
    return PolicyData(RECORDED, look, POINTS, episodes=episodes, solved_only=solved_only)


def test_actions_lead_from_what_was_seen_to_the_end_and_no_further() -> None:
    seen, actions = data().draw(400, np.random.default_rng(0))
    old, now = seen.gripper[:, 0].numpy(), seen.gripper[:, 1].numpy()
    whole = now + STRIDE * actions[:, 1:].numpy().sum(axis=1)
    ends = RECORDED.gripper[RECORDED.first_state[1:] - 1, :3]
    assert np.isin(np.round(now, 5), np.round(RECORDED.gripper[:, :3], 5)).all()
    first = (old == now).all(axis=1)  # at the beginning the present is all there is to see
    begins = RECORDED.gripper[RECORDED.first_state[:-1], :3]
    assert first.any()
    assert np.isin(now[first], begins).all()
    np.testing.assert_allclose(
        now[~first] - old[~first], STRIDE * actions[~first, 0].numpy(), atol=1e-6
    )
    still = (actions[:, -1] == 0).all(dim=1).numpy()
    assert still.any()
    assert not still.all()
    reached = np.abs(whole[still][:, None] - ends).max(axis=2).min(axis=1)
    np.testing.assert_allclose(reached, 0.0, atol=1e-5)


def test_the_goal_is_the_last_state_of_the_episode_or_of_one_like_it() -> None:
    seen, _ = data().draw(2000, np.random.default_rng(1))
    own = (seen.scene == seen.goal_scene).flatten(1).all(dim=1).numpy()
    ends = RECORDED.first_state[1:] - 1
    goals = seen.goal[:, 0].numpy()
    which = np.abs(goals[:, None] - RECORDED.nodes[ends, 0]).max(axis=2).argmin(axis=1)
    np.testing.assert_allclose(goals, RECORDED.nodes[ends, 0][which], atol=1e-6)
    # Six episodes in three scenes, three of a kind, each in another scene.
    assert own.mean() == pytest.approx(1 - FOREIGN * 2 / 3, abs=0.04)
    step = seen.object[:, 1, 0].numpy()
    episode = np.abs(step[:, None] - RECORDED.nodes[:, 0]).max(axis=2).argmin(axis=1)
    episode = np.searchsorted(RECORDED.first_state, episode, side="right") - 1
    assert (RECORDED.success[episode] == RECORDED.success[which]).all()
    assert (episode[own] == which[own]).all()


def test_every_step_is_as_likely() -> None:
    seen, _ = data().draw(20_000, np.random.default_rng(2))
    now = seen.gripper[:, 1].numpy()
    row = np.abs(now[:, None] - RECORDED.gripper[:, :3]).max(axis=2).argmin(axis=1)
    counts = np.bincount(row, minlength=len(RECORDED.gripper))
    ends = RECORDED.first_state[1:] - 1
    assert (counts[ends] == 0).all()  # nothing was done there
    others = np.delete(counts, ends)
    assert others.min() > 0.5 * others.mean()


def test_only_solved_episodes_if_so_wanted() -> None:
    assert data(solved_only=True).episodes == 3
    assert data(episodes=2).steps == RECORDED.lengths[:2].sum()
    seen, _ = data(solved_only=True).draw(500, np.random.default_rng(3))
    ends = RECORDED.first_state[1:] - 1
    goals = seen.goal[:, 0].numpy()
    which = np.abs(goals[:, None] - RECORDED.nodes[ends, 0]).max(axis=2).argmin(axis=1)
    assert RECORDED.success[which].all()


def test_no_solved_episode_is_refused() -> None:
    unsolved = toy_demonstrations()
    unsolved.success[:] = False
    with pytest.raises(InvalidOptionError, match="solved its task"):
        PolicyData(unsolved, Look(POINTS, None), POINTS, episodes=6, solved_only=True)


def test_limits_hold_all_places() -> None:
    found = data()
    seen, _ = found.draw(500, np.random.default_rng(4))
    low, high = found.limits
    for part in seen:
        assert (part[..., :3] >= low).all()
        assert (part[..., :3] <= high).all()


def test_same_draws_same_bits() -> None:
    config = dataclasses.replace(POINTS, observed=3)
    found = PolicyData(RECORDED, Look(config, None), config, episodes=6, solved_only=False)
    first, again = (found.draw(8, np.random.default_rng(5)) for _ in range(2))
    assert first.seen.gripper.shape == (8, 3, 3)
    for one, other in zip((*first.seen, first.actions), (*again.seen, again.actions), strict=True):
        assert (one == other).all()
