"""SAC with hindsight: what a Gymnasium user would try first. Not in the paper.

Trained by Stable-Baselines3 through the ordinary environment (``icd-bench train sac-her``); what
acts is its actor alone, in plain PyTorch, so that weights are no pickle.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor, nn

from icd_agent.checkpoints import check_task, load_checkpoint, read_about
from icd_agent.completion import Completion, seen_scene
from icd_agent.observed import checked
from icd_agent.options import is_count, require
from icd_agent.policy.look import evenly
from icd_agent.weights import SAC_HER, shipped_folder
from icd_envs.api import Episode, Float32Array, Observation
from icd_envs.errors import NOT_BEGUN, EpisodeStateError

KIND: Final = "actor"
CLOUDS: Final = ("achieved_goal", "desired_goal", "goal_scene", "scene")
"""In the order of their features, that of the environment's dictionary."""
OBJECT: Final = ("achieved_goal", "desired_goal")
ACTION: Final = 3
GRIPPER: Final = 6


@dataclass(frozen=True)
class ActorConfig:
    """Sizes of the actor.

    Attributes:
        object_points: kept of object and goal.
        scene_points: kept of either scene.
        point_widths: of the layers that every point goes through.
        widths: of the layers after them.
    """

    object_points: int
    scene_points: int
    point_widths: tuple[int, ...]
    widths: tuple[int, ...]

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for name in ("object_points", "scene_points"):
            require(is_count(getattr(self, name)), name, getattr(self, name), "an integer >= 1")
        for name in ("point_widths", "widths"):
            value = getattr(self, name)
            good = len(value) >= 1 and all(is_count(width) for width in value)
            require(good, name, value, "integers >= 1")

    @classmethod
    def of(cls, given: dict[str, Any]) -> ActorConfig:
        """From a checkpoint's record, in which tuples are lists."""
        widths = {name: tuple(given[name]) for name in ("point_widths", "widths")}
        return cls(**{**given, **widths})


class Actor(nn.Module):
    """The deterministic part of SAC's actor: a PointNet for every cloud, then a perceptron."""

    def __init__(self, config: ActorConfig) -> None:
        """Build the layers."""
        super().__init__()
        self.config = config
        self.point_net = _perceptron((3, *config.point_widths))
        features = len(CLOUDS) * config.point_widths[-1] + GRIPPER
        self.perceptron = _perceptron((features, *config.widths))
        self.mean = nn.Linear(config.widths[-1], ACTION)

    def forward(self, clouds: dict[str, Tensor], gripper: Tensor) -> Tensor:
        """Actions (B, 3) in [-1, 1].

        Args:
            clouds: (B, N, 3) [m] by name.
            gripper: (B, 6) position [m] and velocity [m/s].
        """
        parts = [self.point_net(clouds[name]).amax(dim=1) for name in CLOUDS]
        found: Tensor = self.mean(self.perceptron(torch.cat([*parts, gripper], dim=1)))
        return found.tanh()


def _perceptron(widths: tuple[int, ...]) -> nn.Sequential:
    layers = [layer for two in pairwise(widths) for layer in (nn.Linear(*two), nn.ReLU())]
    return nn.Sequential(*layers)


class ActorAgent:
    """Takes the actor's action; it draws nothing."""

    needs_simulator = False
    needs_oracle = False

    def __init__(self, actor: Actor) -> None:
        """Wrap an actor in evaluation mode."""
        self.actor = actor
        self._completion: Completion | None = None

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; ``seed`` is not used."""
        self._completion = Completion(episode.canonical_cloud)

    @torch.no_grad()
    def act(self, observation: Observation) -> Float32Array:
        """Return an action, (3,) in [-1, 1].

        Args:
            observation: the present one; hidden points of the object are guessed from those that
                are seen, hidden points of the scene are left out.

        Raises:
            EpisodeStateError: before ``reset``.
            InvalidObservationError: not what an environment observes, not finite, or without a
                point of the scene that is seen.
        """
        if self._completion is None:
            raise EpisodeStateError(NOT_BEGUN)
        seen = self._completion(checked(observation))
        config, parts = self.actor.config, {**seen, "scene": seen_scene(seen)}
        clouds = {}
        for name in CLOUDS:
            cloud: Any = parts[name]
            count = config.object_points if name in OBJECT else config.scene_points
            clouds[name] = torch.from_numpy(cloud[evenly(len(cloud), count)])[None]
        gripper = torch.from_numpy(np.array(parts["observation"]))[None]
        action: Float32Array = np.asarray(self.actor(clouds, gripper)[0])
        return action


def load_actor(folder: Path) -> Actor:
    """Read a trained actor.

    Raises:
        CheckpointError: see ``icd_agent.checkpoints.load_checkpoint``.
    """
    return load_checkpoint(folder, KIND, lambda given: Actor(ActorConfig.of(given)))


def make_sac_her(env_id: str, weights: Path | None = None) -> ActorAgent:
    """Build it.

    Raises:
        CheckpointError: missing or damaged weights, or those of another task.
    """
    folder = weights or shipped_folder(env_id, SAC_HER)
    check_task(read_about(folder), env_id)
    return ActorAgent(load_actor(folder))
