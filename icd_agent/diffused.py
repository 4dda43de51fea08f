"""Subgoals from latent diffusion: encode now and goal, generate a chain, decode it."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from icd_agent.chain import Placed, Subgoals
from icd_agent.diffusion.generate import Generated, Generator, Task
from icd_agent.field.field import SceneField
from icd_agent.latent.model import LatentModel
from icd_agent.scene_tokens import scene_tokens
from icd_envs.api import Episode, FloatArray, Observation


class DiffusedSource:
    """The paper's Implicit Contact Diffuser as a source of subgoals.

    Attributes:
        generated: the last chain, as latents; None before the first.
    """

    needs_oracle = False

    def __init__(self, field: SceneField, latent: LatentModel, generator: Generator) -> None:
        """Put together; all in evaluation mode, and trained on one another.

        Args:
            field: describes the scene.
            latent: encodes and decodes features of the cost space.
            generator: draws chains of its latents.
        """
        self._field = field
        self._latent = latent
        self._generator = generator
        self.generated: Generated | None = None

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Generate subgoals from now to the goal; now itself is not one of them."""
        canonical = torch.from_numpy(np.ascontiguousarray(episode.canonical_cloud, np.float32))
        goal = np.asarray(space.goal(observation["desired_goal"]), np.float32)
        foreign = not np.array_equal(observation["scene"], observation["goal_scene"])
        now = self._encode(space.here(observation["achieved_goal"]), canonical)
        size = self._latent.config.scene_size
        middle = observation["achieved_goal"].mean(axis=0)
        mask = observation.get("scene_mask")
        scene = observation["scene"]
        seen = scene if mask is None else scene[np.asarray(mask) > 0]
        tokens = torch.from_numpy(scene_tokens(self._field, seen).seen_from(middle, size))
        task = Task(now, self._encode(goal, canonical), foreign, tokens)
        self.generated = self._generator.generate(task, rng)
        with torch.no_grad():
            features = self._latent.decode(self.generated.latents[1:], canonical).numpy()
        if not foreign or self._generator.config.inpaint_goal:
            features[-1] = goal  # better known than the autoencoder can say
        return Subgoals(features)

    def _encode(self, features: FloatArray, canonical: Tensor) -> Tensor:
        one = torch.from_numpy(np.ascontiguousarray(features, np.float32))[None]
        with torch.no_grad():
            return self._latent.encode(one, canonical)[0]
