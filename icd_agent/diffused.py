"""Subgoals from latent diffusion: encode now and goal, generate a chain, decode it."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import torch
from torch import Tensor

from icd_agent.chain import Placed, Subgoals
from icd_agent.diffusion.config import ChainConfig
from icd_agent.diffusion.generate import Generated, Task
from icd_agent.encoded import decode, encode
from icd_agent.field.field import SceneField
from icd_agent.latent.model import LatentModel
from icd_agent.scene_tokens import scene_tokens
from icd_envs.api import Episode, FloatArray, Observation


class ChainGenerator(Protocol):
    """What finds chains of latents: ``Generator``, or one that looks them up."""

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
    found: Generated
    goal: FloatArray
    canonical: FloatArray


class DiffusedSource:
    """The paper's Implicit Contact Diffuser as a source of subgoals."""

    needs_oracle = False

    def __init__(self, field: SceneField, latent: LatentModel, generator: ChainGenerator) -> None:
        """Put together; all in evaluation mode, and trained on one another.

        Args:
            field: describes the scene.
            latent: encodes and decodes features of the cost space.
            generator: finds chains of its latents.
        """
        self._field = field
        self._latent = latent
        self._generator = generator
        self._last: _Asked | None = None

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Generate subgoals from now to the goal; now itself is not one of them."""
        return self._decode(self._generate(episode, observation, space, rng))

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
        asked = self._generate(episode, observation, space, rng)
        if self._generator.config.keep_shorter and index is not None:
            ahead = self._last.found.latents[index + 1 :]
            left = torch.cat([asked.task.now[None], ahead])
            steps = self._generator.steps(left[None], asked.task.scene)
            if float(steps.sum()) <= float(asked.found.steps.sum()):
                return None
        return self._decode(asked)

    def _generate(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> _Asked:
        canonical = episode.canonical_cloud
        goal = space.goal(observation["desired_goal"])
        ends = np.stack([space.here(observation["achieved_goal"]), goal])
        now, wanted = encode(self._latent, ends, canonical)
        task = Task(
            now=now,
            goal=wanted,
            foreign=not np.array_equal(observation["scene"], observation["goal_scene"]),
            scene=self._tokens(observation),
        )
        return _Asked(task, self._generator.generate(task, rng), goal, canonical)

    def _decode(self, asked: _Asked) -> Subgoals:
        features = decode(self._latent, asked.found.latents, asked.canonical)
        if not asked.task.foreign or self._generator.config.inpaint_goal:
            features[-1] = asked.goal  # better known than the autoencoder can say
        self._last = asked
        return Subgoals(features[1:], begin=features[0])

    def _tokens(self, observation: Observation) -> Tensor:
        mask = observation.get("scene_mask")
        scene = observation["scene"]
        seen = scene if mask is None else scene[np.asarray(mask) > 0]
        middle, size = observation["achieved_goal"].mean(axis=0), self._latent.config.scene_size
        return torch.from_numpy(scene_tokens(self._field, seen).seen_from(middle, size))
