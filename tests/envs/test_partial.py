"""What the partial view shows of the full one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from icd_envs.tasks.env import ContactEnv
from icd_envs.tasks.partial import NOISE, UNSEEN
from tests.envs.making import CABLE, digest, make, play

Pair = tuple[ContactEnv[Any], ContactEnv[Any]]
"""The same environment with a partial and with the full view."""


@pytest.fixture(scope="module")
def pair() -> Iterator[Pair]:
    envs = make(CABLE, obs_mode="partial"), make(CABLE)
    yield envs
    for env in envs:
        env.close()


def expert_steps(pair: Pair, seed: int) -> Iterator[tuple[dict[str, Any], ...]]:
    """Partial and full observation and infos along the expert's way."""
    partial, full = pair
    seen, whole = partial.reset(seed=seed), full.reset(seed=seed)
    yield seen[0], whole[0], seen[1], whole[1]  # type: ignore[misc]
    oracle = full.episode(oracle=True).oracle
    assert oracle is not None
    for action in oracle.actions:
        here, there = partial.step(action), full.step(action)
        assert here[1:4] == there[1:4]
        yield here[0], there[0], here[4], there[4]  # type: ignore[misc]


def test_view_is_the_full_one_with_noise_where_seen_and_nothing_elsewhere(pair: Pair) -> None:
    errors = []
    for seen, whole, info, true_info in expert_steps(pair, 0):
        for name in ("is_success", "complete_rate", "diverged"):
            assert info[name] == true_info[name]
        for name in ("observation", "desired_goal", "goal_scene"):
            np.testing.assert_array_equal(seen[name], whole[name])
        for name in ("achieved_goal", "scene"):
            mask = seen[f"{name}_mask"]
            assert set(np.unique(mask)) <= {0.0, 1.0}
            assert np.all(seen[name][mask == 0] == UNSEEN)
            errors.append((seen[name] - whole[name])[mask == 1])
    error = np.concatenate(errors)
    assert error.std() == pytest.approx(NOISE, rel=0.02)
    assert abs(error.mean()) < NOISE / 50
    assert abs(np.corrcoef(error.T) - np.eye(3)).max() < 0.02


def test_hand_and_clips_hide_parts_of_the_cable(pair: Pair) -> None:
    shares = [seen["achieved_goal_mask"].mean() for seen, *_ in expert_steps(pair, 0)]
    assert shares[0] == 1.0
    assert min(shares) < 0.3  # the hand passes between camera and cable
    assert 0.5 < np.mean(shares) < 0.98


def test_far_sides_of_clips_are_not_seen(pair: Pair) -> None:
    seen, _ = pair[0].reset(seed=1)
    fixtures, floor = seen["scene_mask"][:800], seen["scene_mask"][800:]  # type: ignore[typeddict-item]
    assert 0.3 < fixtures.mean() < 0.7
    assert floor.mean() > 0.8


def test_restored_state_is_seen_as_before_and_each_step_differently(pair: Pair) -> None:
    env, _ = pair
    env.reset(seed=2)
    state = env.snapshot()
    first = play(env, np.zeros((3, 3), np.float32))
    env.restore(state)
    assert digest(play(env, np.zeros((3, 3), np.float32))) == digest(first)
    noise = [observation["scene"][800:] for observation in first]
    assert not np.array_equal(noise[0], noise[1])


def test_rendering_options_change_nothing_that_is_observed(pair: Pair) -> None:
    other = make(CABLE, obs_mode="partial", camera="top", width=64, height=64)
    assert digest([other.reset(seed=3)[0]]) == digest([pair[0].reset(seed=3)[0]])
    other.close()
