"""The networks of ICD: read together, fitting one another."""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

from icd_agent.checkpoints import check_made_with, save_checkpoint, weights_sha256
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.diffusion.train import KIND as DIFFUSION
from icd_agent.diffusion.train import load_diffusion
from icd_agent.field.field import SceneField
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.latent.model import LatentModel
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent
from icd_agent.weights import LOCAL, LOCAL_FIELD, chains_in, shipped_chains, shipped_folder
from icd_envs.errors import CheckpointError

WHOLE: Final = "whole"
"""Folder of the field that chains are generated in, if they are followed in another."""


class Networks(NamedTuple):
    """What ICD has learned, all in evaluation mode.

    Attributes:
        field: in whose descriptors chains are followed.
        latent: autoencoder of object states.
        diffusion: generates chains of its latents.
        whole: field whose descriptors are encoded, with one code for the whole scene, because these
            are much the same in another scene; None is ``field``, as in the paper.
    """

    field: SceneField
    latent: LatentModel
    diffusion: Denoiser
    whole: SceneField | None = None

    @property
    def encoded(self) -> SceneField:
        """The field whose descriptors are encoded."""
        return self.field if self.whole is None else self.whole


def load_networks(folder: Path) -> Networks:
    """Read what ``save_networks`` has written.

    Raises:
        CheckpointError: missing or damaged weights, or of networks trained on another field.
    """
    whole = load_field(folder / WHOLE) if (folder / WHOLE).is_dir() else None
    found = Networks(
        load_field(folder / FIELD),
        load_latent(folder / LATENT),
        load_diffusion(folder / DIFFUSION),
        whole,
    )
    encoded = weights_sha256(folder / (FIELD if whole is None else WHOLE))
    for part in (LATENT, DIFFUSION):
        check_made_with(folder / part, FIELD, encoded)
    return found


def load_shipped(env_id: str) -> Networks:
    """Read the package's weights: chains are generated where that did best, followed locally.

    Raises:
        CheckpointError: there are none for this environment, or they are damaged.
    """
    generated = load_networks(shipped_chains(env_id))
    if chains_in(env_id) == LOCAL:
        return generated
    local = load_field(shipped_folder(env_id, LOCAL_FIELD))
    return generated._replace(field=local, whole=generated.field)


def save_networks(networks: Networks, folder: Path) -> None:
    """Write the weights; files of the same names are replaced."""
    save_checkpoint(folder / FIELD, FIELD, networks.field, networks.field.config, {})
    if networks.whole is not None:
        save_checkpoint(folder / WHOLE, FIELD, networks.whole, networks.whole.config, {})
    encoded = FIELD if networks.whole is None else WHOLE
    about = {"data": {FIELD: weights_sha256(folder / encoded)}}
    for part, network in ((LATENT, networks.latent), (DIFFUSION, networks.diffusion)):
        save_checkpoint(folder / part, part, network, network.config, about)


def check_fit(networks: Networks) -> None:
    """Refuse networks of different widths.

    Raises:
        CheckpointError: they were not trained on one another.
    """
    described, latent = networks.encoded.config.descriptor, networks.latent.config
    diffusion = networks.diffusion.config
    if not latent.features == latent.scene_features == diffusion.scene_features == described:
        raise CheckpointError(
            f"the field describes points by {described} numbers, but the autoencoder takes "
            f"{latent.features} features and scene tokens of {latent.scene_features}, the denoiser "
            f"of {diffusion.scene_features}: use networks that were trained on one another"
        )
    if latent.latent != diffusion.latent:
        raise CheckpointError(
            f"latents have {latent.latent} numbers, but the denoiser takes {diffusion.latent} "
            "numbers: use networks that were trained on one another"
        )


def find_folder(source: str | Path) -> Path:
    """Folder of weights: ``source`` itself, or the download of a repository on the hub.

    Args:
        source: a folder, or ``owner/name`` of a repository on the Hugging Face hub.
    """
    if isinstance(source, Path) or Path(source).is_dir() or source.count("/") != 1:
        return Path(source)
    from huggingface_hub import snapshot_download

    return Path(snapshot_download(source, allow_patterns=["*.json", "*.safetensors"]))
