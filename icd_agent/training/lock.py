"""One training at a time in a folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from icd_envs.errors import TrainingError

LOCK_NAME: Final = ".lock"


@contextmanager
def alone(out: Path) -> Iterator[None]:
    """Make a folder if it is missing, and keep every other training out of it.

    Args:
        out: of the run.

    Raises:
        TrainingError: not writable, or in use.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = FileLock(out / LOCK_NAME, timeout=0)
        lock.acquire()
    except Timeout as error:
        raise TrainingError(
            f"{out} is in use by another training: wait for it, or choose another --out"
        ) from error
    except OSError as error:
        raise TrainingError(f"cannot write to {out}: {error}: choose another --out") from error
    try:
        yield
    finally:
        lock.release()
