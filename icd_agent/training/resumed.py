"""What a run that goes on needs to know of the one before: what differs, and how far it logged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from icd_agent.replacing import cannot_write, write_atomically
from icd_envs.errors import TrainingError

_MISSING: Final = "nothing"


def differences(before: Any, now: Any, name: str = "") -> list[str]:  # noqa: ANN401  any JSON
    """Which values of two records differ, and how.

    Args:
        before: what was read back, JSON.
        now: what is wanted, JSON.
        name: of what is compared; empty at the top.

    Returns:
        One text a value, e.g. ``training.steps (60 there, 61 now)``, in the order of their names.
    """
    if not (isinstance(before, dict) and isinstance(now, dict)):
        return [] if before == now else [f"{name} ({_shown(before)} there, {_shown(now)} now)"]
    return [
        difference
        for key in sorted(before.keys() | now.keys())
        for difference in differences(
            before.get(key, _MISSING), now.get(key, _MISSING), f"{name}.{key}".lstrip(".")
        )
    ]


def cut_log(path: Path, step: int) -> None:
    """Drop what a killed run has logged after its last save: it is done, and logged, again.

    Args:
        path: of the log, a JSON object with a ``step`` a line; it may be missing.
        step: of the last save.

    Raises:
        TrainingError: it cannot be read or written.
    """
    try:
        lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
        kept = [line for line in lines if _logged(line) <= step]
        if kept != lines:
            write_atomically(path, b"".join(kept))
    except OSError as error:
        raise TrainingError(cannot_write(path, error)) from error


def _logged(line: bytes) -> float:
    """Step of a line; infinite for one that a kill has torn."""
    try:
        return float(json.loads(line)["step"])
    except (ValueError, KeyError, TypeError):
        return float("inf")


def _shown(value: object) -> str:
    return value if value is _MISSING else json.dumps(value)
