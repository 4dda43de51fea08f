"""ICD as a policy object: weights in, actions out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from icd_agent.chain import WithPlaces
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.generate import Generator
from icd_agent.field.space import ExactFieldSpace, FieldSpace
from icd_agent.networks import (
    WHOLE,
    Networks,
    check_fit,
    find_folder,
    load_networks,
    load_shipped,
    save_networks,
)
from icd_agent.observed import checked
from icd_agent.plan_info import PlanInfo
from icd_agent.presets import PRESETS, best_preset
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import LOCAL, shipped_folder
from icd_envs.api import Episode, Float32Array, Observation, PlanView
from icd_envs.errors import CheckpointError, EpisodeStateError, InvalidOptionError, unknown_name


class Env(Protocol):
    """What ``predict`` needs of an environment: ours, or a wrapper of it."""

    @property
    def unwrapped(self) -> Any:  # noqa: ANN401  Gymnasium's own type
        """The environment of this project."""
        ...


class ICDAgent:
    """Implicit Contact Diffuser: an agent of the benchmark and a Stable-Baselines3-like policy.

    Attributes:
        needs_simulator: True; MPPI rolls out in it.
        needs_oracle: False.
        networks: what it has learned.
        preset: name of its settings.
        tracker: follows the generated chains.
    """

    needs_simulator = True
    needs_oracle = False

    def __init__(
        self, networks: Networks, preset: str = "improved", *, env: Env | None = None
    ) -> None:
        """Compose an agent.

        Args:
            networks: trained on one another.
            preset: "paper", "improved" or "careful".
            env: gives ``predict`` the simulator; the benchmark's runner needs none.

        Raises:
            InvalidOptionError: unknown preset.
            CheckpointError: the networks do not fit one another or the task of ``env``; or the
                preset decodes subgoals and there are two fields, or asks the field at generated
                places and none are generated.
        """
        if preset not in PRESETS:
            raise InvalidOptionError(unknown_name("ICD preset", preset, PRESETS))
        check_fit(networks)
        if env is not None:
            networks.check_task(getattr(env.unwrapped.spec, "id", None))
        settings = PRESETS[preset]
        if networks.whole is not None and not settings.chain.ask_field:
            raise CheckpointError(
                f"preset {preset!r} follows decoded descriptors, but by {WHOLE!r} these weights "
                "encode another field's than they follow: use weights trained on one field"
            )
        if settings.chain.ask_field and networks.diffusion.config.places == 0:
            raise CheckpointError(
                f"preset {preset!r} asks the field at generated places, but this denoiser has "
                "places=0 and generates none: use preset 'paper', or one with places"
            )
        self.networks = networks
        self.preset = preset
        self._env = env
        generator = Generator(networks.diffusion, networks.latent, settings.chain)
        space = FieldSpace(networks.field)
        encoded_in = None if networks.whole is None else ExactFieldSpace(networks.whole)
        self.tracker = SubgoalTracker(
            DiffusedSource(networks.encoded, networks.latent, generator, encoded_in=encoded_in),
            WithPlaces(space, settings.places) if settings.places else space,
            settings.mppi,
            settings.tracker,
        )
        self._ready = False

    @classmethod
    def from_pretrained(
        cls, source: str | Path, preset: str | None = None, *, env: Env | None = None
    ) -> ICDAgent:
        """Load an agent.

        Args:
            source: a folder that ``save_pretrained`` has written; or the id of an environment, for
                the weights of the package (with "paper" those of ICD on the local field alone); or
                ``owner/name`` of a repository on the Hugging Face hub, which is downloaded. A
                ``Path`` is always a folder, as is what names one that is there.
            preset: "paper", "improved" or "careful"; None is what did best in the environment that
                the weights were trained for, and "improved" if they do not tell.
            env: gives ``predict`` the simulator.

        Raises:
            CheckpointError: missing or damaged weights, or those of another task than ``env``.
            InvalidOptionError: unknown preset.
        """
        folder = find_folder(source)
        if folder is not None:
            networks = load_networks(folder)
        elif preset == "paper":
            networks = load_networks(shipped_folder(str(source), LOCAL))
        else:
            networks = load_shipped(str(source))
        return cls(networks, preset or best_preset(networks.env_id), env=env)

    def save_pretrained(self, folder: str | Path) -> None:
        """Write the weights, for ``from_pretrained``; files of the same names are replaced."""
        save_networks(self.networks, Path(folder))

    @property
    def plan_info(self) -> PlanInfo | None:
        """What the last ``act`` did."""
        return self.tracker.plan_info

    def reset(self, episode: Episode, seed: int) -> None:
        """Begin an episode; see ``SubgoalTracker.reset``.

        Args:
            episode: with a simulator.
            seed: of all draws in the episode.

        Raises:
            CheckpointError: the weights are those of another task.
            InvalidOptionError: the episode has no simulator.
        """
        self.networks.check_task(episode.env_id)
        self.tracker.reset(episode, seed)

    def act(self, observation: Observation) -> Float32Array:
        """Plan one step: (3,) in [-1, 1]; the first of an episode bakes the scene, seconds.

        Raises:
            EpisodeStateError: called before ``reset``.
            InvalidObservationError: parts are missing, of another shape, or not finite.
        """
        return self.tracker.act(observation)

    def plan_view(self) -> PlanView | None:
        """What viewers may draw of the last ``act``."""
        return self.tracker.plan_view()

    def predict(
        self,
        observation: dict[str, Any],
        state: tuple[Any, ...] | None = None,
        episode_start: Any = None,  # noqa: ANN401  Stable-Baselines3's signature
        deterministic: bool = True,
    ) -> tuple[Float32Array, tuple[Any, ...] | None]:
        """Stable-Baselines3's policy interface, for ``evaluate_policy``.

        Args:
            observation: of ``env``, or a batch of one from a vector environment around it.
            state: returned as it is.
            episode_start: (1,) whether an episode begins, besides at the first call and whenever
                ``env`` stands where ``reset`` leaves it.
            deterministic: not used; draws follow from the seed 0 of every episode.

        Returns:
            (3,) action in [-1, 1], or (1, 3) for a batch of one; and ``state``.

        Raises:
            EpisodeStateError: the agent was made without ``env``, or with another than the one that
                was observed.
            InvalidOptionError: a batch of several environments.
            InvalidObservationError: not the environment's dictionary of whole clouds.
        """
        if self._env is None:
            raise EpisodeStateError(
                "predict() needs the environment's simulator: make the agent with env=..."
            )
        unwrapped = self._env.unwrapped
        goal = unwrapped.goal
        single, batched = _unbatched(observation, len(goal))
        if not np.array_equal(single["desired_goal"], goal):
            raise EpisodeStateError(
                "observation has another desired_goal than the environment that the agent was made "
                "with: make it with env=... the one that is observed, and wrap that one"
            )
        begins = episode_start is not None and np.any(episode_start)
        if begins or not self._ready or unwrapped.snapshot().steps == 0:
            self.reset(unwrapped.episode(simulator=True), seed=0)
            self._ready = True
        action = self.act(single)
        return (action[None] if batched else action), state


def _unbatched(observation: object, points: int) -> tuple[Observation, bool]:
    """An observation of one environment, and whether it was a batch of one."""
    if not isinstance(observation, Mapping) or np.ndim(observation.get("achieved_goal", ())) != 3:
        return checked(observation, points), False
    count = len(observation["achieved_goal"])
    if count != 1:
        raise InvalidOptionError(f"observation holds {count} environments: predict one")
    return checked({name: value[0] for name, value in observation.items()}, points), True
