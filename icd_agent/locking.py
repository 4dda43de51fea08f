"""Folders that one process writes at a time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from icd_envs.errors import IcdError, TrainingError

LOCK_NAME: Final = ".lock"


@contextmanager
def alone(
    out: Path,
    what: str = "training",
    error: type[IcdError] = TrainingError,
    instead: str = "choose another --out",
) -> Iterator[None]:
    """Make a folder if it is missing, and keep every other writer out of it.

    Args:
        out: the folder.
        what: writes there, for messages.
        error: to be raised.
        instead: what else its user can do than wait, for messages.

    Raises:
        IcdError: of the type ``error``: not writable, or in use.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = FileLock(out / LOCK_NAME, timeout=0)
        lock.acquire()
    except Timeout as cause:
        raise error(f"{out} is in use by another {what}: wait for it, or {instead}") from cause
    except OSError as cause:
        raise error(f"cannot write to {out}: {cause}: {instead}") from cause
    try:
        yield
    finally:
        lock.release()
