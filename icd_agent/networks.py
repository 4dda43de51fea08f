"""The networks of ICD: read together, fitting one another."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal, NamedTuple

from torch import nn

from icd_agent.checkpoints import (
    check_made_with,
    check_task,
    read_about,
    save_checkpoint,
    trained_for,
    weights_sha256,
)
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.diffusion.train import KIND as DIFFUSION
from icd_agent.diffusion.train import load_diffusion
from icd_agent.field.field import SceneField
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent
from icd_agent.replacing import current, replacing
from icd_agent.weights import (
    LOCAL,
    LOCAL_FIELD,
    TRAINED_FOR,
    chains_in,
    shipped_chains,
    shipped_folder,
    weights_name,
)
from icd_envs.errors import CheckpointError, unknown_name

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
            another (see also ``check_fit``), or of another task than that of ``env_id``.
    """
    folder = current(folder)
    field, latent = load_field(folder / FIELD), load_latent(folder / LATENT)
    diffusion = load_diffusion(folder / DIFFUSION)
    encoded = encoded_part(folder)
    whole = None if encoded == FIELD else load_field(folder / WHOLE)
    for part in (LATENT, DIFFUSION):
        check_made_with(folder / part, FIELD, folder / encoded)
    check_made_with(folder / DIFFUSION, LATENT, folder / LATENT)
    about = {part: read_about(folder / part) for part in (FIELD, encoded, LATENT, DIFFUSION)}
    found = Networks(field, latent, diffusion, whole, about)
    for task in (found.env_id, env_id):
        found.check_task(task)
    check_fit(found)
    return found


def one_field(networks: Networks, scope: Literal["local", "global"]) -> Networks:
    """The same, if chains are generated and followed in one field of this scope.

    Args:
        networks: any.
        scope: see ``FieldConfig``.

    Raises:
        CheckpointError: there are two fields, or one of the other scope.
    """
    if networks.whole is not None:
        raise CheckpointError(
            f"one field is wanted, of scope {scope!r}, but these weights generate chains in "
            f"another ({WHOLE!r}) than they follow: use weights trained on one field, or agent icd"
        )
    if (found := networks.field.config.scope) != scope:
        raise CheckpointError(
            f"a field of scope {scope!r} is wanted, but these weights have one of scope {found!r}: "
            f"icd-bench train field --scope {scope}"
        )
    return networks


def encoded_part(folder: Path) -> str:
    """Name of the part whose descriptors are encoded: ``whole`` if it is there.

    If the autoencoder tells that it was trained with ``field``, ``whole`` is another agent's.

    Args:
        folder: of the parts.

    Raises:
        CheckpointError: missing or damaged weights.
    """
    trained_with = read_about(folder / LATENT).get("data", {}).get(FIELD)
    alone = not (folder / WHOLE).is_dir() or trained_with == weights_sha256(folder / FIELD)
    return FIELD if alone else WHOLE


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
    """Write the weights and how they were trained, instead of those that are there.

    A kill leaves all of the old networks or all of the new ones.
    """

    def save(part: str, kind: str, network: nn.Module, config: object) -> None:
        about = networks.about.get(part, {})
        if kind != FIELD:  # what it was trained with is saved in other files
            about = {**about, "data": {**about.get("data", {}), **made_with}}
        save_checkpoint(new / part, kind, network, config, about)
        made_with[kind] = weights_sha256(new / part)

    made_with: dict[str, str] = {}
    with replacing(folder) as new:
        save(FIELD, FIELD, networks.field, networks.field.config)
        if networks.whole is not None:
            save(WHOLE, FIELD, networks.whole, networks.whole.config)
        save(LATENT, LATENT, networks.latent, networks.latent.config)
        save(DIFFUSION, DIFFUSION, networks.diffusion, networks.diffusion.config)
    if networks.whole is None:
        shutil.rmtree(folder / WHOLE, ignore_errors=True)


def check_fit(networks: Networks) -> None:
    """Refuse networks of different sizes.

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
    check_chains(latent, diffusion)


def check_chains(latent: LatentConfig, diffusion: DiffusionConfig) -> None:
    """Refuse a denoiser of latents of other sizes, objects or scenes.

    Raises:
        CheckpointError: they were not trained on one another.
    """
    for name in ("latent", "points", "scene_features", "scene_size"):
        has, takes = getattr(latent, name), getattr(diffusion, name)
        if has != takes:
            raise CheckpointError(
                f"{name}={has} of the autoencoder, but {name}={takes} of the denoiser: use "
                "networks that were trained on one another"
            )


def find_folder(source: str | Path) -> Path | None:
    """Folder of weights; None if an id is given, for the weights of the package.

    Args:
        source: a folder; or the id of an environment; or ``owner/name`` of a repository on the
            Hugging Face hub, which is downloaded. A folder that is there, and any ``Path``, is one.

    Raises:
        CheckpointError: it is none of these, or could not be downloaded.
    """
    if isinstance(source, Path) or Path(source).is_dir():
        return Path(source)
    if weights_name(source) is not None:
        return None
    if "/" not in source:
        known = unknown_name("folder, or environment with shipped weights:", source, TRAINED_FOR)
        raise CheckpointError(known)
    if source.count("/") > 1 or source.startswith((".", "/", "~")):
        raise CheckpointError(f"{source} is no folder: name what save_pretrained has written")
    from huggingface_hub import snapshot_download

    try:
        return Path(snapshot_download(source, allow_patterns=["*.json", "*.safetensors"]))
    except Exception as error:  # the hub and the network each fail in ways of their own
        raise CheckpointError(
            f"{source} is no folder here, and as a repository of the Hugging Face hub it cannot be "
            f"downloaded: {type(error).__name__}: {error}"
        ) from error
