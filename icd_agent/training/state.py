"""The state of a training run: written in one step, read back by the same run only."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import torch

from icd_agent.replacing import cannot_write, write_atomically
from icd_agent.training.resumed import differences
from icd_envs.errors import TrainingError


def save_state(path: Path, run: dict[str, Any], state: dict[str, Any]) -> None:
    """Write; a kill or a full disk leaves the last one whole.

    Args:
        path: of the file.
        run: what makes the run the same one, JSON.
        state: tensors and numbers.

    Raises:
        TrainingError: the file system did not take it.
    """
    content = io.BytesIO()
    torch.save({**state, "run": json.dumps(run, sort_keys=True)}, content)
    try:
        write_atomically(path, content.getvalue())
    except OSError as error:
        raise TrainingError(cannot_write(path, error)) from error


def read_state(path: Path, run: dict[str, Any]) -> dict[str, Any] | None:
    """What ``save_state`` has written; None if there is nothing.

    Args:
        path: of the file.
        run: that wants to go on.

    Raises:
        TrainingError: the file is damaged, or of another run.
    """
    if not path.exists():
        return None
    try:
        state: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
        before = json.loads(state["run"])
    except Exception as error:  # zip, pickle and JSON each fail in ways of their own
        raise TrainingError(f"{path} is damaged: {error}: delete it and train again") from error
    if before != run:
        raise TrainingError(
            f"cannot go on with {path.parent}: it was trained with other "
            f"{', '.join(differences(before, run))}: choose another --out"
        )
    return state
