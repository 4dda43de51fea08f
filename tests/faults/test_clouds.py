"""Clouds that hold nothing, too much or garbage: a defined answer, or an error that says why."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from icd_envs import ENV_IDS
from icd_envs.api import Float64Array
from icd_envs.errors import InvalidObservationError, InvalidOptionError
from icd_envs.geometry.folding import cover_gap, fold_gap, on_top
from icd_envs.geometry.routing import find_crossing, passes_behind, signed_crossings
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.clip import Clip
from icd_envs.tasks.env import ContactEnv
from icd_envs.wrappers import FlattenPointCloud, NoisyObservations, SubsamplePointCloud
from tests.envs.making import make, remake

SEEDS = st.integers(0, 2**32 - 1)
CLIP = Clip((0.1, -0.05), 0.6)
MANY = 1_000_000
TABLE = np.array([0.0, 0.0, 0.3, 0.4, 0.4, 0.0])
"""Position x, y [m], yaw [rad], half extents x, y [m], height [m]."""

Cloud = Any
"""What somebody hands over as one."""


@pytest.fixture(scope="module", params=ENV_IDS)
def partial(request: pytest.FixtureRequest) -> Iterator[ContactEnv[Any]]:
    env = make(request.param, obs_mode="partial")
    env.reset(seed=0)
    yield env
    env.close()


def test_nothing_seen_is_still_an_observation(
    partial: ContactEnv[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    state = partial.snapshot()
    monkeypatch.setattr(
        "icd_envs.tasks.partial.PointCamera.sees", lambda *args: np.zeros(len(args[2]), bool)
    )
    observation, reward, *_, info = partial.step(np.zeros(3))
    for name in ("achieved_goal", "scene"):
        assert not observation[name].any()  # type: ignore[literal-required]
        assert not observation[f"{name}_mask"].any()  # type: ignore[literal-required]
    assert partial.observation_space.contains(observation)
    assert reward in (-1.0, 0.0)
    desired = observation["desired_goal"]
    assert partial.compute_reward(observation["achieved_goal"], desired, info) in (-1.0, 0.0)
    for wrapped in (
        SubsamplePointCloud(partial, 20, 30),
        FlattenPointCloud(SubsamplePointCloud(partial)),
        FlattenPointCloud(NoisyObservations(partial, 0.01)),
    ):
        seen = wrapped.step(np.zeros(3))[0]
        assert wrapped.observation_space.contains(seen)
    partial.restore(state)


class Replaced(gym.ObservationWrapper[dict[str, Any], Any, Any]):
    """Shows another array in place of one part."""

    def __init__(self, env: gym.Env[Any, Any], name: str, value: Cloud) -> None:
        super().__init__(env)
        self.name, self.value = name, value

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        return {**observation, self.name: self.value}


WRAPPERS = {
    "flat": FlattenPointCloud,
    "small": SubsamplePointCloud,
    "noisy": lambda env: NoisyObservations(env, 0.01),
}


@pytest.mark.parametrize("wrap", WRAPPERS)
@pytest.mark.parametrize("name", ["achieved_goal", "scene"])
def test_wrappers_refuse_what_is_not_finite_or_of_another_size(
    partial: ContactEnv[Any], wrap: str, name: str
) -> None:
    shape = partial.observation_space[name].shape  # type: ignore[index]
    holed = np.zeros(shape)
    holed[-1, 2] = np.nan
    for value in (holed, np.full(shape, np.inf), np.zeros((0, 3)), np.zeros((MANY, 3))):
        env = WRAPPERS[wrap](Replaced(partial, name, value))
        with pytest.raises(InvalidObservationError, match=rf"observation\['{name}'\]"):
            env.step(np.zeros(3))


@pytest.mark.parametrize("wrap", WRAPPERS)
def test_wrappers_make_float32_of_double_precision_and_duplicates(
    partial: ContactEnv[Any], wrap: str
) -> None:
    same = np.full(partial.observation_space["scene"].shape, 0.25)  # type: ignore[index]
    env = WRAPPERS[wrap](Replaced(partial, "scene", same))
    assert env.observation_space.contains(env.step(np.zeros(3))[0])


def test_noise_needs_the_parts_that_it_is_added_to(partial: ContactEnv[Any]) -> None:
    class Blind(gym.ObservationWrapper[Any, Any, Any]):
        observation_space = gym.spaces.Dict({"scene": gym.spaces.Box(-1, 1, (5, 3))})

        def observation(self, observation: Any) -> Any:  # noqa: ANN401
            return observation

    with pytest.raises(InvalidOptionError, match="observes 'observation'"):
        NoisyObservations(Blind(partial), 0.01)


UNUSABLE: dict[str, Any] = {
    "nan": lambda cloud: np.where(np.arange(len(cloud))[:, None] == 7, np.nan, cloud),
    "infinite": lambda cloud: np.full_like(cloud, np.inf),
    "no points": lambda cloud: cloud[:0],
    "plane": lambda cloud: cloud[:, :2],
    "flat": lambda cloud: cloud.ravel(),
    "deep": lambda cloud: cloud[None, None],
    "one point": lambda cloud: cloud[0],
    "fewer points": lambda cloud: cloud[:-1],
    "batch": lambda cloud: cloud[None],
    "ragged": lambda cloud: [*cloud.tolist(), [0.0]],
    "text": lambda cloud: "cloud",
    "texts": lambda cloud: cloud.astype(str),
    "none": lambda cloud: None,
    "complex": lambda cloud: cloud.astype(complex),
}


@pytest.mark.parametrize("kind", UNUSABLE)
def test_reward_of_garbage_is_refused(env: ContactEnv[Any], kind: str) -> None:
    observation, info = first_step(env)
    cloud, bad = observation["desired_goal"], UNUSABLE[kind](observation["desired_goal"])
    with pytest.raises(InvalidObservationError, match="achieved_goal"):
        env.compute_reward(bad, cloud, info)
    with pytest.raises(InvalidObservationError, match="desired_goal"):
        env.compute_reward(cloud, bad, info)


def test_reward_without_its_scene_is_refused(env: ContactEnv[Any]) -> None:
    observation, info = first_step(env)
    cloud = observation["desired_goal"]
    batch = np.stack([cloud, cloud])
    name = env.task.parameter_names[0]
    without = {key: value for key, value in info.items() if key != f"goal_{name}"}
    for bad in ({}, without):
        with pytest.raises(InvalidObservationError, match=f"{name}.*copy_info_dict=True"):
            env.compute_reward(cloud, cloud, bad)
    for infos in ([info], [info] * 3, info, [info, {}], [info, None]):
        with pytest.raises(InvalidObservationError, match="info"):
            env.compute_reward(batch, batch, infos)  # type: ignore[arg-type]


def test_reward_of_clouds_in_other_forms_is_the_same(env: ContactEnv[Any]) -> None:
    observation, info = first_step(env)
    achieved, desired = observation["scene"][:200], observation["desired_goal"]
    expected = env.compute_reward(achieved, desired, info)
    double = achieved.astype(np.float64), desired.astype(np.float64)
    assert env.compute_reward(*double, info) == pytest.approx(expected, abs=1e-6)
    lists = achieved.tolist(), desired.tolist()
    assert env.compute_reward(*lists, info) == pytest.approx(expected, abs=1e-6)  # type: ignore[arg-type]


@pytest.mark.parametrize("reward_type", ["sparse", "dense"])
def test_reward_of_one_point_of_many_and_of_none_is_defined(
    env: ContactEnv[Any], reward_type: str
) -> None:
    observation, info = first_step(env)
    other: Any = remake(env, reward_type=reward_type).unwrapped
    cloud = observation["desired_goal"]
    same = np.repeat(cloud[:1], len(cloud), axis=0)
    many = np.repeat(cloud, MANY // len(cloud), axis=0)
    for achieved, desired in ((same, cloud), (cloud, same), (same, same), (many, many)):
        reward = other.compute_reward(achieved, desired, info)
        assert np.isfinite(reward)
        assert reward <= 0.0
    none = np.empty((0, *cloud.shape))
    assert other.compute_reward(none, none, []).shape == (0,)


def first_step(env: ContactEnv[Any]) -> tuple[Any, dict[str, Any]]:
    """An observation and its info; the next test begins where this one did."""
    state = env.snapshot()
    observation, *_, info = env.step(np.zeros(3))
    env.restore(state)
    return observation, info


def wandering_cable(seed: int) -> Float64Array:
    """(60, 3) polyline around a clip."""
    steps = np.random.default_rng(seed).normal(0.0, 0.03, (60, 3))
    return np.array([*CLIP.position, 0.03]) + np.cumsum(steps, axis=0)


def crossings(cable: Float64Array) -> int:
    """Of the clip."""
    return int(signed_crossings(cable, np.array([CLIP.pose]))[0])


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_duplicate_points_pass_no_clip(seed: int) -> None:
    cable = wandering_cable(seed)
    doubled = np.repeat(cable, 3, axis=0)
    assert crossings(doubled) == crossings(cable)
    assert (find_crossing(doubled, CLIP) is None) == (find_crossing(cable, CLIP) is None)
    assert passes_behind(doubled, CLIP) == passes_behind(cable, CLIP)


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sampled_from([np.nan, np.inf, -np.inf]))
@pytest.mark.filterwarnings("ignore:invalid value")
def test_points_that_are_not_finite_pass_no_clip(seed: int, value: float) -> None:
    cable = wandering_cable(seed)
    assert crossings(np.full_like(cable, value)) == 0
    holed = cable.copy()
    holed[::7] = value
    # As if the cable were cut there: pieces on their own pass what they pass.
    pieces = [piece for piece in np.split(cable, range(7, 60, 7)) if len(piece) > 2]
    assert crossings(holed) == sum(crossings(piece[1:]) for piece in pieces)


def test_a_million_points_pass_as_the_few_that_they_lie_between() -> None:
    at = np.linspace(0.0, 59.0, MANY)
    found = set()
    for seed in range(4):
        cable = wandering_cable(seed)
        fine = np.column_stack([np.interp(at, range(60), axis) for axis in cable.T])
        assert crossings(fine) == crossings(cable)
        found.add(crossings(cable))
    assert len(found) > 1


def test_distance_of_a_point_does_not_depend_on_its_neighbours() -> None:
    union = BoxUnion(CLIP.boxes())
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (300, 3))
    expected = union(points)
    holed = points.copy()
    holed[::2] = np.nan
    found = union(holed)
    assert np.isnan(found[::2]).all()
    np.testing.assert_allclose(found[1::2], expected[1::2], atol=1e-15)
    many = union(np.repeat(points, MANY // 300, axis=0)).reshape(300, -1)
    np.testing.assert_allclose(many, np.repeat(expected[:, None], MANY // 300, axis=1), atol=1e-15)


def test_notebook_of_one_point_is_folded_and_one_that_is_not_finite_is_not() -> None:
    nothing = np.zeros((200, 3))
    assert fold_gap(nothing) == cover_gap(nothing) == 0.0
    assert bool(on_top(nothing, TABLE))
    holed = nothing.copy()
    holed[3] = np.nan
    for cloud in (holed, np.full_like(holed, np.nan)):
        assert not fold_gap(cloud) < 1.0
        assert not bool(on_top(cloud, TABLE))
    assert bool(on_top(np.zeros((MANY, 3), np.float32), TABLE))
