"""Folders that one process writes at a time, and files that are whole or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from benchmarks.errors import ResultsError

LOCK_NAME: Final = ".lock"


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Make a folder if it is missing, and keep every other writer out.

    Raises:
        ResultsError: not writable, or in use.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        lock = FileLock(path / LOCK_NAME, timeout=0)
        lock.acquire()
    except Timeout as error:
        raise ResultsError(
            f"{path} is in use by another run: wait for it, or choose another --out"
        ) from error
    except OSError as error:
        raise ResultsError(f"cannot write to {path}: {error}: choose another --out") from error
    try:
        yield
    finally:
        lock.release()


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file in one step: whatever happens, it has the old content or the new.

    Raises:
        OSError: the file system did not take it; the old file is untouched.
    """
    temporary = path.with_name(f"{path.name}.tmp")
    try:
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
