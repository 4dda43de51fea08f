"""The agent of all action-chunk policies: generates actions, executes some, generates again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import torch
from torch import Tensor

from icd_agent.checkpoints import (
    check_made_with,
    check_task,
    read_about,
    save_checkpoint,
    trained_for,
    weights_sha256,
)
from icd_agent.completion import Completion, seen_scene
from icd_agent.field.field import SceneField
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.observed import checked
from icd_agent.policy.encoders import Seen
from icd_agent.policy.look import Look
from icd_agent.policy.policy import KIND, ChunkPolicy, load_policy
from icd_agent.replacing import current, replacing
from icd_agent.weights import LOCAL_FIELD, shipped_folder
from icd_envs.api import Episode, Float32Array, FloatArray, Observation, PlanView
from icd_envs.errors import NOT_BEGUN, EpisodeStateError


class ChunkAgent:
    """A policy in receding horizon; it sees observations only.

    Attributes:
        needs_simulator: False.
        needs_oracle: False.
        policy: what acts.
    """

    needs_simulator = False
    needs_oracle = False

    def __init__(
        self,
        policy: ChunkPolicy,
        field: SceneField | None = None,
        about: Mapping[str, dict[str, Any]] = MappingProxyType({}),
    ) -> None:
        """Put together.

        Args:
            policy: in evaluation mode.
            field: the one it was trained with; None for policies that see points.
            about: how they were trained, by the names of their folders.

        Raises:
            CheckpointError: they do not fit one another.
        """
        self.policy = policy
        self._field = field
        self._about = about
        self._look = Look(policy.config, field)
        self._rng: np.random.Generator | None = None

    @classmethod
    def from_pretrained(cls, folder: str | Path, env_id: str | None = None) -> ChunkAgent:
        """Load what ``save_pretrained`` or ``icd-bench train`` has written.

        Args:
            folder: of the policy; without a field beside it, a policy that needs one has the
                package's for the environment that it was trained for.
            env_id: where it is to be used, if that is known.

        Raises:
            CheckpointError: missing or damaged weights, of a policy that was trained with another
                field, or of another task than that of ``env_id``.
        """
        parts = current(Path(folder))
        place = parts / KIND if (parts / KIND).is_dir() else parts
        policy, about = load_policy(place), read_about(place)
        check_task(about, env_id)
        if policy.config.sees != "key points":
            return cls(policy, None, {KIND: about})
        seen, trained = parts / FIELD, trained_for(about)
        if trained is not None and not seen.is_dir():
            seen = shipped_folder(trained, LOCAL_FIELD)
        check_made_with(place, FIELD, seen)
        return cls(policy, load_field(seen), {KIND: about, FIELD: read_about(seen)})

    def save_pretrained(self, folder: str | Path) -> None:
        """Write the weights, for ``from_pretrained``, instead of those that are there."""
        about, field = self._about.get(KIND, {}), self._field
        with replacing(Path(folder)) as new:
            if field is not None:
                told = self._about.get(FIELD, {})
                save_checkpoint(new / FIELD, FIELD, field, field.config, told)
                made_with = {FIELD: weights_sha256(new / FIELD)}
                about = {**about, "data": {**about.get("data", {}), **made_with}}
            save_checkpoint(new / KIND, KIND, self.policy, self.policy.config, about)

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; ``seed`` is the only source of randomness.

        Raises:
            CheckpointError: the policy was trained for another task.
        """
        check_task(self._about.get(KIND, {}), episode.env_id)
        self._rng = np.random.default_rng(seed)
        self._completion = Completion(episode.canonical_cloud)
        self._scenes: tuple[Tensor, Tensor] | None = None
        self._observed: list[tuple[FloatArray, FloatArray]] = []
        self._ahead: list[Float32Array] = []

    def act(self, observation: Observation) -> Float32Array:
        """Return an action, (3,) in [-1, 1].

        Args:
            observation: the present one; scenes are looked at once an episode, and hidden points
                of the object are guessed from those that are seen.

        Raises:
            EpisodeStateError: before ``reset``.
            InvalidObservationError: not what an environment observes, not finite, or at the
                beginning of an episode without a point of the scene that is seen.
        """
        if self._rng is None:
            raise EpisodeStateError(NOT_BEGUN)
        observation = self._completion(checked(observation))
        if self._scenes is None:
            self._scenes = self._look_at(observation)
        config = self.policy.config
        now = observation["observation"][:3].copy(), self._look.object(observation["achieved_goal"])
        self._observed = [*(self._observed or [now] * config.observed), now][-config.observed :]
        if not self._ahead:
            chunk = self.policy.sample(self._seen(observation), self._rng)[0]
            first = config.observed - 1
            self._ahead = list(chunk[first : first + config.executed])
        self._plan = np.stack(self._ahead)
        return self._ahead.pop(0)

    def plan_view(self) -> PlanView | None:
        """The actions of the last chunk that had not been executed; None before the first."""
        if self._rng is None or not self._observed:
            return None
        return PlanView(actions=self._plan)

    def _look_at(self, observation: Observation) -> tuple[Tensor, Tensor]:
        here = self._look.scene(seen_scene(observation))
        there = self._look.scene(observation["goal_scene"])
        return torch.from_numpy(here)[None], torch.from_numpy(there)[None]

    def _seen(self, observation: Observation) -> Seen:
        assert self._scenes is not None
        grippers, clouds = zip(*self._observed, strict=True)
        goal = self._look.object(observation["desired_goal"])
        return Seen(
            torch.from_numpy(np.stack(grippers))[None],
            torch.from_numpy(np.stack(clouds))[None],
            torch.from_numpy(goal)[None],
            *self._scenes,
        )
