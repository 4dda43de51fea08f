"""Which networks a command works with: those that it was given, or else the package's."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from icd_agent.checkpoints import CONFIG_NAME, WEIGHTS_NAME, check_made_with
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent
from icd_agent.replacing import current, replacing, write_synced
from icd_agent.weights import LOCAL_FIELD, shipped_chains, shipped_folder
from icd_envs.errors import CheckpointError


class ChainParts(NamedTuple):
    """Folders of what chains are generated in.

    Attributes:
        field: describes the scene.
        latent: encodes its descriptors.
    """

    field: Path
    latent: Path


def part(env_id: str, name: str, given: Path | None) -> Path:
    """Folder of a part of ICD's chains.

    Args:
        env_id: whose weights of the package, if none are given.
        name: ``field``, ``latent`` or ``diffusion``.
        given: a folder; None is the package's.

    Raises:
        CheckpointError: none is given, and none is shipped for this environment.
    """
    return shipped_chains(env_id, name) if given is None else given


def local_field(env_id: str, given: Path | None) -> Path:
    """Folder of the field that agents follow chains in and baselines see scenes by.

    Args:
        env_id: whose weights of the package, if none are given.
        given: a folder; None is the package's.

    Raises:
        CheckpointError: none is given, and none is shipped for this environment.
    """
    return shipped_folder(env_id, LOCAL_FIELD) if given is None else given


def chain_parts(env_id: str, field: Path | None, latent: Path | None) -> ChainParts:
    """Folders of a field, and of an autoencoder of its descriptors.

    Args:
        env_id: whose weights of the package, for what is not given.
        field: a folder; None is the package's.
        latent: a folder; None is the package's.

    Raises:
        CheckpointError: missing or damaged weights, or the autoencoder is of another field or of
            no descriptors at all, as the one of Subgoal Diffuser is.
    """
    found = ChainParts(part(env_id, FIELD, field), part(env_id, LATENT, latent))
    check_made_with(found.latent, FIELD, found.field)
    takes = load_latent(found.latent).config.features
    described = load_field(found.field).config.descriptor
    if takes != described:
        raise CheckpointError(
            f"the autoencoder in {found.latent} takes {takes} numbers a point, but the field in "
            f"{found.field} describes one by {described}: give one of descriptors, which icd-bench "
            "train latent makes; Subgoal Diffuser's is one of places"
        )
    return found


def check_places(denoiser: Denoiser) -> None:
    """Refuse a denoiser whose subgoals are no object clouds, as Subgoal Diffuser's.

    Raises:
        CheckpointError: it was trained with ``places=0``.
    """
    if not denoiser.config.places:
        raise CheckpointError(
            "the denoiser was trained with places=0, its subgoals have no place in the scene: give "
            "one of icd-bench train diffusion"
        )


def keep_beside(field: Path | None, out: Path) -> None:
    """Copy a field into the folder of what was trained with it: together they are an agent.

    Args:
        field: a folder; None is the package's, which agents find anyway.
        out: folder of the run.
    """
    if field is None or field.resolve() == (out / FIELD).resolve():
        return
    with replacing(out / FIELD) as new:
        for name in (CONFIG_NAME, WEIGHTS_NAME):
            write_synced(new / name, (current(field) / name).read_bytes())
