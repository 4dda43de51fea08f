"""The ablation ladder: agents that know the answer, to find out which part of a method fails."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from icd_agent.chain import Placed, PointSpace, Subgoals, SubgoalSource
from icd_agent.mppi.presets import ADAPTIVE, PAPER
from icd_agent.tracking import SubgoalTracker, TrackerConfig
from icd_agent.weights import (
    GLOBAL_FIELD,
    LOCAL_FIELD,
    shipped_chains,
    shipped_folder,
    weights_name,
)
from icd_envs.api import Episode, Observation
from icd_envs.errors import InvalidOptionError

if TYPE_CHECKING:
    from icd_agent.field.field import SceneField

ORACLE_STRIDE = 10
"""Expert steps between subgoals: about one horizon, so that each can be reached in one plan."""

ONE_AT_A_TIME = TrackerConfig(window=1, patience=40)
"""With a window of 3 the tracker skipped the lift over a clip in 2 of 20 scenes."""

BY_CONTACT = TrackerConfig(threshold=0.5, spacing="own", window=1, patience=20)
"""For descriptors: with the median spacing, subgoals near contact were waited for in vain; 183
to 188 steps instead of 135 to 142 in two training scenes."""

WITH_CARE = replace(BY_CONTACT, threshold=0.35, patience=40)
"""For those of the notebook, which must hang right before it touches the table: 5 of 5 training
scenes, against 3 of 6 with ``BY_CONTACT``, where it landed on the wrong side."""


class OracleSource:
    """States of the scripted expert's own solution, every few steps, and its last one."""

    needs_oracle = True

    def __init__(self, scene: Literal["present", "goal"] = "present") -> None:
        """Choose a solution.

        Args:
            scene: the solution of the present scene, or of the one the goal was specified in;
                they differ in the adaptation tasks only.
        """
        self._scene = scene

    def chain(
        self, episode: Episode, observation: Observation, space: Placed, rng: np.random.Generator
    ) -> Subgoals:
        """Return the expert's states.

        Raises:
            InvalidOptionError: if the episode has no oracle.
        """
        oracle = episode.oracle if self._scene == "present" else episode.goal_oracle
        if oracle is None:
            raise InvalidOptionError(
                "the episode has no oracle, but oracle subgoals need the expert's states: "
                "build it with oracle=True"
            )
        last = len(oracle.points) - 1
        clouds = oracle.points[np.unique(np.r_[0:last:ORACLE_STRIDE, last])]
        features = space.here if self._scene == "present" else space.goal
        return Subgoals(features(clouds), clouds)


def make_oracle_points() -> SubgoalTracker:
    """Build rung 1: oracle subgoals, distances in points; what fails here is the tracking."""
    return SubgoalTracker(OracleSource(), PointSpace(), PAPER, ONE_AT_A_TIME)


def make_transferred_points() -> SubgoalTracker:
    """Build the control of the adaptation tasks: the same with the solution of the goal's scene.

    It knows where everything was, so what it lacks is that contacts matter, not places.
    """
    return SubgoalTracker(OracleSource("goal"), PointSpace(), PAPER, ONE_AT_A_TIME)


def make_oracle_descriptors(env_id: str) -> SubgoalTracker:
    """Build rung 2: oracle subgoals, distances in descriptors; what fails here is the field."""
    return _track_descriptors(OracleSource(), env_id)


def make_transferred_descriptors(env_id: str) -> SubgoalTracker:
    """Build rung 2 of the adaptation tasks: descriptors of the solution of the goal's scene."""
    return _track_descriptors(OracleSource("goal"), env_id)


def make_transferred_global(env_id: str) -> SubgoalTracker:
    """Build the same with descriptors of a field that has one code for the whole scene."""
    return _track_descriptors(OracleSource("goal"), env_id, GLOBAL_FIELD)


def make_vae(env_id: str) -> SubgoalTracker:
    """Build rung 3: oracle subgoals through the autoencoder and back; what fails here is it."""
    from icd_agent.encoded import EncodedSource
    from icd_agent.field.train import KIND as FIELD
    from icd_agent.field.train import load_field
    from icd_agent.latent.train import KIND, load_latent

    latent = load_latent(shipped_chains(env_id, KIND))
    field = load_field(shipped_chains(env_id, FIELD))
    return _track_as_icd(EncodedSource(OracleSource(), latent), field, env_id)


def make_retrieved_chain(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build rung 4: the recorded chain nearest to a generated one; what fails are such chains.

    Args:
        env_id: whose settings, and whose weights of the package.
        weights: folder of ICD's parts and ``chains``; or of chains alone, as ``icd-bench train
            bank`` leaves it, of latents of the package. None is the package's.

    Raises:
        CheckpointError: missing or damaged weights, or such as were not made with one another.
    """
    from icd_agent.checkpoints import check_made_with
    from icd_agent.diffused import DiffusedSource
    from icd_agent.diffusion.generate import Generator
    from icd_agent.diffusion.retrieval import KIND, Retriever, load_bank
    from icd_agent.field.train import KIND as FIELD
    from icd_agent.latent.train import KIND as LATENT
    from icd_agent.networks import encoded_part, load_networks
    from icd_agent.presets import PRESETS, best_preset

    if weights is not None and (weights / KIND).is_dir():
        folder, bank = weights, weights / KIND
    else:
        folder, bank = shipped_chains(env_id), weights or shipped_folder(env_id, KIND)
    networks = load_networks(folder, env_id)
    for part, used in ((FIELD, encoded_part(folder)), (LATENT, LATENT)):
        check_made_with(bank, part, folder / used)
    generator = Generator(networks.diffusion, networks.latent, PRESETS[best_preset(env_id)].chain)
    retriever = Retriever(generator, load_bank(bank))
    source = DiffusedSource(networks.encoded, networks.latent, retriever)
    return _track_as_icd(source, networks.encoded, env_id)


def _track_as_icd(source: SubgoalSource, field: SceneField, env_id: str) -> SubgoalTracker:
    """Follow decoded subgoals: with ICD's tracker, in the field that they were encoded in."""
    from icd_agent.field.space import FieldSpace
    from icd_agent.presets import PRESETS, best_preset

    settings = PRESETS[best_preset(env_id)]
    config = replace(settings.tracker, replan_every=None)
    return SubgoalTracker(source, FieldSpace(field), settings.mppi, config)


def _track_descriptors(
    source: SubgoalSource, env_id: str, field: str = LOCAL_FIELD
) -> SubgoalTracker:
    from icd_agent.field.space import FieldSpace

    space = FieldSpace.shipped(env_id, field)
    config = WITH_CARE if weights_name(env_id) == "notebook-folding" else BY_CONTACT
    return SubgoalTracker(source, space, ADAPTIVE, config)
