"""Subgoals from latent diffusion: encode now and goal, generate a chain, decode it."""

from __future__ import annotations

from typing import Literal, NamedTuple, Protocol

import numpy as np
import torch
from torch import Tensor

from icd_agent.chain import CostSpace, Placed, Subgoals
from icd_agent.completion import seen_scene
from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import ChainConfig
from icd_agent.diffusion.generate import Generated, Task
from icd_agent.encoded import decode, encode
from icd_agent.field.field import SceneField
from icd_agent.latent.model import LatentModel
from icd_agent.options import require
from icd_agent.scene_tokens import Frame, SceneTokens, scene_tokens
from icd_envs.api import Episode, FloatArray, Observation
from icd_envs.errors import CheckpointError


class ChainGenerator(Protocol):
    """What finds chains of latents: ``Generator``, or one that looks them up."""

    code: SubgoalCode
    config: ChainConfig

    def generate(self, task: Task, rng: np.random.Generator) -> Generated:
        """Find a chain."""
        ...

    def steps(self, chains: Tensor, scene: Tensor) -> Tensor:
        """Predicted control steps (C, L - 1) between consecutive latents (C, L, Z)."""
        ...


class _Asked(NamedTuple):
    """A question, its answer, and what is needed to decode it."""

    task: Task
    frame: Frame
    found: Generated
    wanted: FloatArray
    canonical: FloatArray


class DiffusedSource:
    """The paper's Implicit Contact Diffuser as a source of subgoals."""

    needs_oracle = False

    def __init__(
        self,
        field: SceneField,
        latent: LatentModel,
        generator: ChainGenerator,
        seen_from: Literal["now", "start"] = "now",
        encoded_in: CostSpace | None = None,
    ) -> None:
        """Put together; all in evaluation mode, and trained on one another.

        Args:
            field: describes the scene.
            latent: encodes and decodes features of object states.
            generator: finds chains of its latents.
            seen_from: where the object is when the scene is looked at, as in training.
            encoded_in: whose features these are; None is the space in which the chain is followed.

        Raises:
            InvalidOptionError: ``encoded_in`` with a generator whose chains are decoded, which
                could not be followed in another space.
        """
        asked = generator.config.ask_field and len(generator.code.components) > 0
        require(encoded_in is None or asked, "encoded_in", encoded_in, "None: chains are decoded")
        self._field = field
        self._latent = latent
        self._generator = generator
        self._seen_from = seen_from
        self._encoded_in = encoded_in
        self._tokens: SceneTokens | None = None
        self._last: _Asked | None = None

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Begin an episode: look at its scene, generate subgoals from now to the goal.

        Now itself is not one of them.

        Raises:
            CheckpointError: the space has other features than the latents were trained on.
        """
        self._tokens = scene_tokens(self._field, seen_scene(observation))
        self._encoded = space
        if self._encoded_in is not None:
            self._encoded = self._encoded_in.place(observation, foreign=episode.foreign_goal)
        self._start = observation["achieved_goal"].mean(axis=0)
        return self._decode(self._generate(episode, observation, rng), space)

    def again(
        self,
        episode: Episode,
        observation: Observation,
        space: Placed,
        rng: np.random.Generator,
        index: int | None,
    ) -> Subgoals | None:
        """Generate another chain; None if what is left of the last one takes fewer steps.

        A chain that was followed to its end in vain is always replaced.
        """
        assert self._last is not None
        asked = self._generate(episode, observation, rng)
        if self._generator.config.keep_shorter and index is not None:
            ahead = self._last.found.latents[index + 1 :]
            left = torch.cat([asked.found.latents[:1], ahead])
            steps = self._generator.steps(left[None], asked.task.scene)
            if float(steps.sum()) <= float(asked.found.steps.sum()):
                return None
        return self._decode(asked, space)

    def _generate(
        self, episode: Episode, observation: Observation, rng: np.random.Generator
    ) -> _Asked:
        canonical = episode.canonical_cloud
        now, wanted = observation["achieved_goal"], observation["desired_goal"]
        encoded = self._encoded
        features = np.stack([encoded.here(now), encoded.goal(wanted)])
        described = features.shape[-1] - encoded.beside
        if described != self._latent.config.features:
            raise CheckpointError(
                f"the space describes points by {described} numbers, but these latents were "
                f"trained on {self._latent.config.features}: use the field they were trained with"
            )
        latents = encode(self._latent, features[..., :described], canonical)
        assert self._tokens is not None
        tokens = self._tokens
        middle = now.mean(axis=0) if self._seen_from == "now" else self._start
        frame = goal_frame = tokens.frame(middle)
        code, inpaint = self._generator.code, self._generator.config.inpaint_goal
        foreign = episode.foreign_goal
        if foreign and inpaint:  # as if it were of the present scene
            goal_frame = scene_tokens(self._field, observation["goal_scene"]).frame(middle)
        there = None if foreign and not inpaint else _placed(goal_frame, wanted)
        task = Task(
            now=code.join(latents[0], _placed(frame, now)),
            goal=code.join(latents[1], there),
            foreign=foreign,
            scene=torch.from_numpy(tokens.seen_from(middle, self._latent.config.scene_size)),
        )
        found = self._generator.generate(task, rng)
        return _Asked(task, frame, found, wanted, canonical)

    def _decode(self, asked: _Asked, space: Placed) -> Subgoals:
        found, config = asked.found, self._generator.config
        clouds: FloatArray | None = None
        if found.clouds is not None:
            clouds = asked.frame.back(found.clouds.numpy())
        if clouds is None or not config.ask_field:
            features = decode(self._latent, found.latents, asked.canonical)
        else:
            features = space.here(clouds.astype(np.float32))
        if not asked.task.foreign or config.inpaint_goal:
            features[-1] = space.goal(asked.wanted)  # better known than can be generated
        if not asked.task.foreign and clouds is not None:
            clouds[-1] = asked.wanted
        if clouds is None and space.back is not None:
            clouds = space.back(features)
        self._last = asked
        made = None if clouds is None else clouds[1:]
        return Subgoals(features[1:], made, features[0], found.steps.numpy())


def _placed(frame: Frame, cloud: FloatArray) -> Tensor:
    return torch.from_numpy(frame.place(cloud).astype(np.float32))
