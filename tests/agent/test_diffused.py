"""A source that is asked again: which chain is kept, and whence the scene is seen."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
import torch
from torch import Tensor

from icd_agent.chain import Placed, Subgoals
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import ChainConfig, DiffusionConfig
from icd_agent.diffusion.generate import Generated, Task
from icd_agent.encoded import decode, encode
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.latent.principal import principal
from icd_agent.scene_tokens import TOKENS, scene_tokens
from icd_agent.training.initial import initialise
from icd_envs.api import Observation
from tests.agent.field.small import SMALL, scene, small_field
from tests.agent.toy_world import POINTS, ToyWorld

SIZES = LatentConfig(
    3, SMALL.descriptor, POINTS, latent=6, groups=4, neighbours=3, width=8, decoder_width=8
)
SPACE = Placed(lambda points: 2.0 * points, lambda points: 3.0 * points)
FIELD, CLOUD = small_field(), scene(0).cloud
THERE = (0.2, 0.0, 0.1)
FIRST = (0.0, 10.0, 30.0, 20.0, 40.0)


def small_latent() -> LatentModel:
    latent = LatentModel(SIZES).eval()
    initialise(latent, torch.Generator().manual_seed(0))
    return latent


LATENT = small_latent()


class Scripted:
    """Answers with the next of given chains: subgoals on a line, whose distances are steps."""

    def __init__(self, *chains: tuple[float, ...], keep_shorter: bool = True) -> None:
        sizes = DiffusionConfig(SIZES.latent, SMALL.descriptor, POINTS, TOKENS, places=2)
        clouds = np.random.default_rng(0).normal(size=(20, POINTS, 3)).astype(np.float32)
        self.code = SubgoalCode(sizes, principal(clouds, 2))
        self.config = ChainConfig(keep_shorter=keep_shorter)
        self.chains = [latents_at(chain) for chain in chains]
        self.asked: list[Task] = []

    def generate(self, task: Task, rng: np.random.Generator) -> Generated:
        latents = self.chains[len(self.asked)]
        self.asked.append(task)
        return Generated(latents, None, self.steps(latents[None], task.scene)[0])

    def steps(self, chains: Tensor, scene: Tensor) -> Tensor:
        assert scene is self.asked[-1].scene
        return chains.diff(dim=1).norm(dim=-1)


class Asked:
    """A source, and questions to it."""

    def __init__(self, generator: Scripted, seen_from: Literal["now", "start"] = "now") -> None:
        self.source = DiffusedSource(FIELD, LATENT, generator, seen_from)
        self.rng = np.random.default_rng(0)

    def begin(self, at: tuple[float, float, float] = THERE) -> Subgoals:
        return self.source.chain(ToyWorld().episode(), observed(at), SPACE, self.rng)

    def again(self, index: int | None, at: tuple[float, float, float] = THERE) -> Subgoals | None:
        return self.source.again(ToyWorld().episode(), observed(at), SPACE, self.rng, index)


def latents_at(chain: tuple[float, ...]) -> Tensor:
    latents = torch.zeros(len(chain), SIZES.latent)
    latents[:, 0] = torch.tensor(chain)
    return latents


def observed(at: tuple[float, float, float]) -> Observation:
    return {**ToyWorld(start=at).observation(), "scene": CLOUD, "goal_scene": CLOUD}


def is_of(found: Subgoals | None, chain: tuple[float, ...]) -> bool:
    """Whether these are the subgoals of a chain: decoded, but for the goal, which is known."""
    expected = decode(LATENT, latents_at(chain), ToyWorld().episode().canonical_cloud)
    expected[-1] = SPACE.goal(ToyWorld().observation()["desired_goal"])
    return (
        found is not None
        and found.begin is not None
        and np.array_equal(found.features, expected[1:])
        and np.array_equal(found.begin, expected[0])
    )


@pytest.mark.parametrize(("steps", "kept"), [(47.0, False), (48.0, True), (49.0, True)])
def test_a_chain_is_replaced_only_by_one_of_fewer_steps_than_are_left_of_it(
    steps: float, kept: bool
) -> None:
    other = (12.0, 12.0 + steps)  # from here to 30, 20 and 40 it is 18 + 10 + 20
    asked = Asked(Scripted(FIRST, other))
    assert is_of(asked.begin(), FIRST)
    found = asked.again(index=1)
    assert found is None if kept else is_of(found, other)


def test_what_is_left_is_that_of_the_last_chain_that_was_followed() -> None:
    longer, shorter = (12.0, 112.0, 12.0, 112.0, 212.0), (25.0, 37.0, 49.0)
    asked = Asked(Scripted(FIRST, longer, (25.0, 50.0), shorter, (30.0, 49.0)))
    asked.begin()
    assert asked.again(index=1) is None
    assert asked.again(index=2) is None  # from 25 to 20 and 40 it is 25, whatever was refused
    assert is_of(asked.again(index=2), shorter)
    assert asked.again(index=0) is None  # from 30 to 37 and 49 it is 19


@pytest.mark.parametrize(("keep_shorter", "index"), [(True, None), (False, 1), (False, None)])
def test_a_chain_followed_in_vain_or_not_to_be_kept_is_replaced_even_by_a_longer_one(
    keep_shorter: bool, index: int | None
) -> None:
    longer = (12.0, 1012.0, 12.0)
    asked = Asked(Scripted(FIRST, longer, keep_shorter=keep_shorter))
    asked.begin()
    assert is_of(asked.again(index), longer)


@pytest.mark.parametrize("seen_from", ["now", "start"])
def test_the_scene_is_seen_from_where_the_object_is_or_was_when_the_episode_began(
    seen_from: Literal["now", "start"],
) -> None:
    generator = Scripted(FIRST, FIRST, FIRST)
    asked, tokens = Asked(generator, seen_from), scene_tokens(FIELD, CLOUD)
    start, now = THERE, (0.3, -0.2, 0.2)
    asked.begin(start)
    asked.again(None, now)
    asked.begin(now)
    seen = {"now": (start, now, now), "start": (start, start, now)}[seen_from]
    for task, at, place in zip(generator.asked, (start, now, now), seen, strict=True):
        cloud, middle = observed(at)["achieved_goal"], observed(place)["achieved_goal"].mean(axis=0)
        np.testing.assert_array_equal(task.scene, tokens.seen_from(middle, SIZES.scene_size))
        latent = encode(LATENT, SPACE.here(cloud)[None], ToyWorld().episode().canonical_cloud)[0]
        placed = torch.from_numpy(tokens.frame(middle).place(cloud)).float()
        torch.testing.assert_close(task.now, generator.code.join(latent, placed))
