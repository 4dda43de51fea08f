"""Trained networks on disk: ``config.json`` and ``model.safetensors``, never a pickle."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn

from icd_agent.replacing import current, replacing, write_synced
from icd_agent.weights import weights_name
from icd_envs.errors import CheckpointError

CONFIG_NAME: Final = "config.json"
WEIGHTS_NAME: Final = "model.safetensors"
FORMAT: Final = 1

ModelT = TypeVar("ModelT", bound=nn.Module)


def save_checkpoint(
    folder: Path,
    kind: str,
    model: nn.Module,
    config: object,
    about: dict[str, Any],
    *,
    half: bool = False,
) -> None:
    """Write a network; the config names the weights' sha256, so that the pair is checked.

    A kill leaves the old pair or the new one.

    Args:
        folder: made if it is missing; files of the same names are replaced.
        kind: what the network is, e.g. ``field``.
        model: its weights are saved.
        config: frozen dataclass that the network is built from.
        about: how it was trained, for people.
        half: save trained weights in half precision; buffers keep theirs. They are read back in the
            network's own.

    Raises:
        CheckpointError: weights that are not finite, or not in half precision, or a folder that
            cannot be written; what was there before is left.
    """
    if not is_dataclass(config) or isinstance(config, type):
        raise TypeError(f"config must be a dataclass, got {config!r}")
    values = {name: x.detach().cpu().contiguous() for name, x in model.state_dict().items()}
    trained = {name for name, _ in model.named_parameters()} if half else set()
    kept = {name: x.half() if name in trained else x for name, x in values.items()}
    if (name := not_finite(kept)) is not None:
        precision = " in half precision, which ends at 65504" if not_finite(values) is None else ""
        raise CheckpointError(
            f"{name} is not finite{precision}: not saved in {folder}, where nothing was changed: "
            "train again with another seed or a lower learning_rate"
        )
    weights = save(kept)
    record = {
        "format": FORMAT,
        "kind": kind,
        "config": asdict(config),
        "sha256": hashlib.sha256(weights).hexdigest(),
        "about": about,
    }
    with replacing(folder) as new:
        write_synced(new / WEIGHTS_NAME, weights)
        write_synced(new / CONFIG_NAME, (json.dumps(record, indent=2) + "\n").encode())


def load_checkpoint(folder: Path, kind: str, build: Callable[[dict[str, Any]], ModelT]) -> ModelT:
    """Read a network, checked against its sha256, in evaluation mode.

    Args:
        folder: written by ``save_checkpoint``.
        kind: what must be there.
        build: makes the network from the config's fields.

    Raises:
        CheckpointError: missing, damaged, of another kind or format, or weights that do not fit
            or are not finite; names the file.
    """
    folder = current(folder)
    record = _read_config(folder)
    if record["format"] != FORMAT or record["kind"] != kind:
        raise CheckpointError(
            f"{folder / CONFIG_NAME} is a {record['kind']!r} of format {record['format']!r}, "
            f"expected {kind!r} of format {FORMAT}"
        )
    path = folder / WEIGHTS_NAME
    try:
        content = path.read_bytes()
    except OSError as error:
        raise CheckpointError(f"cannot read {path}: {error}") from error
    if hashlib.sha256(content).hexdigest() != record["sha256"]:
        raise CheckpointError(
            f"{path} is damaged or not the file that {CONFIG_NAME} belongs to: its sha256 differs; "
            "get both again"
        )
    try:
        with torch.random.fork_rng(devices=[]):  # layers draw weights that are replaced at once
            model = build(record["config"])
        model.load_state_dict(load(content))
    except (SafetensorError, RuntimeError, TypeError, ValueError, LookupError) as error:
        raise CheckpointError(
            f"{path} does not fit its config: {type(error).__name__}: {error}"
        ) from error
    if (name := not_finite(model.state_dict())) is not None:
        raise CheckpointError(f"{path}: {name} is not finite")
    return model.eval()


def not_finite(values: Mapping[str, Tensor]) -> str | None:
    """Name of the first of a network's values that has NaN or inf, if one has."""
    return next(
        (
            name
            for name, value in values.items()
            if value.is_floating_point() and not bool(value.isfinite().all())
        ),
        None,
    )


def weights_sha256(folder: Path) -> str:
    """Name of the weights in a folder, for what depends on them.

    Raises:
        CheckpointError: there is no checkpoint.
    """
    return str(_read_config(folder)["sha256"])


def read_about(folder: Path) -> dict[str, Any]:
    """How the weights in a folder were trained, as ``save_checkpoint`` was told.

    Raises:
        CheckpointError: there is no checkpoint.
    """
    about: dict[str, Any] = _read_config(folder)["about"]
    return about


def check_made_with(folder: Path, part: str, used: Path) -> None:
    """Refuse weights that were trained with other ones; those that do not tell are taken.

    Args:
        folder: of the weights.
        part: what they tell the sha256 of, e.g. ``field``.
        used: folder of what would be used for it; weights may have been rounded since, if they
            tell from which (``rounded_from``).

    Raises:
        CheckpointError: they were trained with others, or are missing.
    """
    told = read_about(folder).get("data", {}).get(part)
    there = weights_sha256(used)
    if told not in (None, there, read_about(used).get("rounded_from")):
        raise CheckpointError(
            f"{folder} was trained with the {part} {str(told)[:12]}, not with {there[:12]} in "
            f"{used}: use networks that were trained on one another"
        )


def trained_for(about: Mapping[str, Any]) -> str | None:
    """Id of the environment that weights were trained for, if they tell.

    Args:
        about: how they were trained.
    """
    env_id: str | None = about.get("data", about.get("training", {})).get("env")
    return env_id


def check_task(about: Mapping[str, Any], env_id: str | None) -> None:
    """Refuse weights of another task of ours; an adaptation task shares those of its task.

    Args:
        about: how they were trained; if that does not tell for what, they are taken.
        env_id: where they are to be used; an environment that is not ours may use any.

    Raises:
        CheckpointError: both are known, and differ.
    """
    trained = trained_for(about)
    theirs, wanted = weights_name(trained or ""), weights_name(env_id or "")
    if theirs and wanted and theirs != wanted:
        raise CheckpointError(
            f"weights that were trained for {trained} cannot be used in {env_id}: use those of its "
            "own task"
        )


def _read_config(folder: Path) -> dict[str, Any]:
    path = current(folder) / CONFIG_NAME
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise CheckpointError(f"cannot read {path}: {error}") from error
    wanted = {"format": int, "kind": str, "config": dict, "sha256": str, "about": dict}
    if not isinstance(record, dict) or any(
        type(record.get(name)) is not kind for name, kind in wanted.items()
    ):
        raise CheckpointError(f"{path} is no checkpoint: it must have the keys {sorted(wanted)}")
    for name in ("data", "training"):
        if not isinstance(record["about"].get(name, {}), dict):
            raise CheckpointError(f"{path} is damaged: about.{name} must be a dictionary")
    return record
