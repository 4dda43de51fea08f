"""The networks of ICD: read together, fitting one another."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from torch import nn

from icd_agent.checkpoints import (
    check_made_with,
    check_task,
    read_about,
    save_checkpoint,
    trained_for,
    weights_sha256,
)
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
        about: how each part was trained, by the name of its folder.
    """

    field: SceneField
    latent: LatentModel
    diffusion: Denoiser
    whole: SceneField | None = None
    about: Mapping[str, dict[str, Any]] = MappingProxyType({})

    @property
    def encoded(self) -> SceneField:
        """The field whose descriptors are encoded."""
        return self.field if self.whole is None else self.whole

    @property
    def env_id(self) -> str | None:
        """Id of the environment that chains were learned in, if it is known."""
        return trained_for(self.about.get(DIFFUSION, {}))

    def check_task(self, env_id: str | None) -> None:
        """Refuse another task of ours than that of the parts; what does not tell is taken.

        Raises:
            CheckpointError: a part was trained for another.
        """
        for about in self.about.values():
            check_task(about, env_id)


def load_networks(folder: Path, env_id: str | None = None) -> Networks:
    """Read what ``save_networks`` has written.

    Args:
        folder: of the parts.
        env_id: where they are to be used, if that is known.

    Raises:
        CheckpointError: missing or damaged weights, of networks that were not trained on one
            another, or of another task than that of ``env_id``.
    """
    whole = load_field(folder / WHOLE) if (folder / WHOLE).is_dir() else None
    field, latent = load_field(folder / FIELD), load_latent(folder / LATENT)
    diffusion = load_diffusion(folder / DIFFUSION)
    encoded = FIELD if whole is None else WHOLE
    for part in (LATENT, DIFFUSION):
        check_made_with(folder / part, FIELD, folder / encoded)
    check_made_with(folder / DIFFUSION, LATENT, folder / LATENT)
    about = {part: read_about(folder / part) for part in (FIELD, encoded, LATENT, DIFFUSION)}
    found = Networks(field, latent, diffusion, whole, about)
    for task in (found.env_id, env_id):
        found.check_task(task)
    return found


def load_shipped(env_id: str) -> Networks:
    """Read the package's weights: chains are generated where that did best, followed locally.

    Raises:
        CheckpointError: there are none for this environment, or they are damaged.
    """
    generated = load_networks(shipped_chains(env_id), env_id)
    if chains_in(env_id) == LOCAL:
        return generated
    folder = shipped_folder(env_id, LOCAL_FIELD)
    about = {**generated.about, WHOLE: generated.about[FIELD], FIELD: read_about(folder)}
    return generated._replace(field=load_field(folder), whole=generated.field, about=about)


def save_networks(networks: Networks, folder: Path) -> None:
    """Write the weights and how they were trained; files of the same names are replaced."""

    def save(part: str, kind: str, network: nn.Module, config: object) -> None:
        about = networks.about.get(part, {})
        if kind != FIELD:  # what it was trained with is saved in other files
            about = {**about, "data": {**about.get("data", {}), **made_with}}
        save_checkpoint(folder / part, kind, network, config, about)
        made_with[kind] = weights_sha256(folder / part)

    made_with: dict[str, str] = {}
    save(FIELD, FIELD, networks.field, networks.field.config)
    if networks.whole is not None:
        save(WHOLE, FIELD, networks.whole, networks.whole.config)
    save(LATENT, LATENT, networks.latent, networks.latent.config)
    save(DIFFUSION, DIFFUSION, networks.diffusion, networks.diffusion.config)


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
