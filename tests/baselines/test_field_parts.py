"""ICD whose chains are followed by a part of what it knows."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from baselines.field_parts import REACH, PartOfField, SeenElsewhere
from icd_agent.chain import Placed, PointSpace, Subgoals
from icd_agent.field.space import exact_features
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.weights import shipped_folder
from icd_envs.api import Episode, FloatArray, Observation
from icd_envs.geometry.point_cloud import sample_scene
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.tasks.cable_routing import CableRouting
from tests.agent.field.small import small_field
from tests.envs.making import CABLE


def test_the_parts_of_a_field_add_up_to_it() -> None:
    field = small_field()
    rng = np.random.default_rng(0)
    scene, points = rng.uniform(0, 0.3, (200, 3)), rng.uniform(0, 0.6, (500, 3))
    near, far = (exact_features(PartOfField(field, part), scene) for part in ("near", "far"))
    whole = exact_features(field, scene)(points)
    np.testing.assert_allclose(near(points) + far(points), whole, atol=1e-6)


def test_near_to_surfaces_is_the_one_part_and_far_from_them_the_other() -> None:
    near, far = (PartOfField(load_field(shipped_folder(CABLE, FIELD)), p) for p in ("near", "far"))
    rng = np.random.default_rng(0)
    task = CableRouting()
    boxes = task.boxes(task.draw_scenes(rng).scene)
    cloud = sample_scene(boxes, 900, 100, rng)
    points = rng.uniform((0.0, -0.4, 0.0), (0.8, 0.4, 0.3), (5000, 3)).astype(np.float32)
    away = BoxUnion(boxes)(points)
    sizes = [np.linalg.norm(exact_features(each, cloud)(points), axis=-1) for each in (near, far)]
    share = sizes[0] / (sizes[0] + sizes[1])
    close, distant = np.abs(away) < 0.1 * REACH, away > 1.5 * REACH
    assert close.sum() > 20
    assert distant.sum() > 20
    assert share[close].mean() > 0.8
    assert share[distant].mean() < 0.05


class Thinker:
    """A source that remembers the space it thinks in."""

    needs_oracle = False

    def __init__(self, keep: bool) -> None:
        self.keep = keep
        self.spaces: list[Placed] = []

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        self.spaces.append(space)
        clouds = np.stack([observation["achieved_goal"], observation["desired_goal"]])
        return Subgoals(space.here(clouds), clouds)

    def again(
        self,
        episode: Episode,
        observation: Observation,
        space: Placed,
        rng: np.random.Generator,
        index: int | None,
    ) -> Subgoals | None:
        chain = self.chain(episode, observation, space, rng)
        return None if self.keep else chain


class Doubled:
    """A space of points, twice as large."""

    def place(self, observation: Observation) -> Placed:
        def doubled(points: FloatArray) -> FloatArray:
            return 2 * points

        return Placed(doubled, doubled)


def test_a_chain_is_followed_in_another_space_than_it_was_thought_in() -> None:
    env: gym.Env[Any, Any] = gym.make(CABLE)
    observation, _ = env.reset(seed=0)
    episode, rng = env.unwrapped.episode(), np.random.default_rng(0)  # type: ignore[attr-defined]
    outer = PointSpace().place(observation)
    for keep in (True, False):
        thinker = Thinker(keep)
        source = SeenElsewhere(thinker, Doubled())
        begun = source.chain(episode, observation, outer, rng)
        again = source.again(episode, observation, outer, rng, 0)
        for space in thinker.spaces:
            assert space.here(np.ones(3))[0] == 2
        np.testing.assert_array_equal(begun.features[-1], observation["desired_goal"])
        assert (again is None) == keep
