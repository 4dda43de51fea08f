"""Subgoal Diffuser: ICD's chains of subgoals and its tracker, with places instead of contacts.

The paper's baseline (section V-B, after Huang et al., ICRA 2024): the same latent diffusion on
object clouds, the same planner, distances in metres.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

from icd_agent.checkpoints import check_made_with, check_task, read_about
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.config import ChainConfig
from icd_agent.diffusion.generate import Generator
from icd_agent.diffusion.train import KIND as DIFFUSION
from icd_agent.diffusion.train import load_diffusion
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent
from icd_agent.mppi.presets import PAPER
from icd_agent.networks import check_chains
from icd_agent.presets import PRESETS, best_preset
from icd_agent.scene_points import ScenePoints
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import LOCAL_FIELD, SUBGOAL_DIFFUSER, shipped_folder
from icd_envs.errors import CheckpointError

PLACE: Final = 3
"""Numbers a point: its autoencoder is one of places."""


def make_subgoal_diffuser(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build it with everything that helps ICD, the transfer of goals of other scenes included."""
    return compose(env_id, weights or shipped_folder(env_id, SUBGOAL_DIFFUSER), best_preset(env_id))


def make_subgoal_diffuser_paper(env_id: str, weights: Path | None = None) -> SubgoalTracker:
    """Build it with the paper's settings: one chain, the goal in-painted where it lies."""
    return compose(env_id, weights or shipped_folder(env_id, SUBGOAL_DIFFUSER), "paper")


def compose(env_id: str, folder: Path, settings: str) -> SubgoalTracker:
    """Put trained networks and a planner together.

    Args:
        env_id: see ``chains_of_places``, as for the folder.
        folder: of the networks.
        settings: name of ICD's preset; with "paper" the planner has the paper's temperature, too,
            which is one of metres.

    Raises:
        CheckpointError: see ``chains_of_places``.
    """
    chosen = PRESETS[settings]
    source, space = chains_of_places(env_id, folder, chosen.chain)
    planner = PAPER if settings == "paper" else chosen.mppi
    return SubgoalTracker(source, space, planner, chosen.tracker)


def chains_of_places(
    env_id: str, folder: Path, settings: ChainConfig
) -> tuple[DiffusedSource, ScenePoints]:
    """Put trained networks together: what generates chains, and the space that they are of.

    Args:
        env_id: whose field of the package tells fixtures from the floor, if the folder has none.
        folder: of ``latent``, ``diffusion`` and perhaps ``field``, as ``icd-bench train
            subgoal-diffuser`` leaves it.
        settings: of ICD's chains; there is no field to be asked.

    Raises:
        CheckpointError: missing or damaged weights, those of another task, or such as were not
            trained on one another.
    """
    seen = folder / FIELD
    if not seen.is_dir():
        seen = shipped_folder(env_id, LOCAL_FIELD)
    for part in (LATENT, DIFFUSION):
        check_task(read_about(folder / part), env_id)
        check_made_with(folder / part, FIELD, seen)
    check_made_with(folder / DIFFUSION, LATENT, folder / LATENT)
    field, latent = load_field(seen), load_latent(folder / LATENT)
    if latent.config.features != PLACE:
        raise CheckpointError(
            f"the autoencoder in {folder / LATENT} takes {latent.config.features} numbers a point, "
            f"not the {PLACE} of a place: give what icd-bench train subgoal-diffuser has made"
        )
    denoiser = load_diffusion(folder / DIFFUSION)
    check_chains(latent.config, denoiser.config)
    generator = Generator(denoiser, latent, replace(settings, ask_field=False))
    source = DiffusedSource(field, latent, generator, seen_from="start")
    return source, ScenePoints(field, "in place" if settings.inpaint_goal else "in its scene")
