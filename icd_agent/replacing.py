"""Files that replace others all together: a kill leaves the old ones or the new ones."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from icd_envs.errors import CheckpointError

WRITTEN: Final = ".written"
"""Folder of files that are all written, but not yet all in their places."""
UNFINISHED: Final = ".unfinished"
"""Folder of files that are being written, or are in their places; what is left of it is void."""


@contextmanager
def replacing(folder: Path) -> Iterator[Path]:
    """Give a folder to write to; in the end its files replace those of the same names.

    Args:
        folder: where the files shall be in the end; made if it is missing, other files stay.

    Raises:
        CheckpointError: the disk is full, or does not let itself be written; nothing half written
            is left, and what loads is all old or all new.
    """
    unfinished = folder / UNFINISHED
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _put_in_place(folder)
        shutil.rmtree(unfinished, ignore_errors=True)
        unfinished.mkdir()
        yield unfinished
        os.rename(unfinished, folder / WRITTEN)
        _put_in_place(folder)
    except Exception as error:
        shutil.rmtree(unfinished, ignore_errors=True)
        if isinstance(error, OSError):
            raise CheckpointError(cannot_write(folder, error)) from error
        raise


def current(folder: Path) -> Path:
    """Where the files of a folder are now: beside their places if their writer was killed."""
    return folder / WRITTEN if (folder / WRITTEN).is_dir() else folder


def write_synced(path: Path, content: bytes) -> None:
    """Write a new file to the disk."""
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file in one step: whatever happens, it has the old content or the new.

    Raises:
        OSError: the file system did not take it; the old file is untouched.
    """
    beside = path.with_name(f"{path.name}.new")
    try:
        write_synced(beside, content)
        os.replace(beside, path)
    except OSError:
        with suppress(OSError):  # it may never have been there, in a folder that is not ours
            beside.unlink(missing_ok=True)
        raise


def cannot_write(path: Path, error: OSError) -> str:
    """What to tell whoever trains of a disk that is full or read-only."""
    return (
        f"cannot write {path}: {error}: free some space or make it writable, then run the same "
        "command again"
    )


def _put_in_place(folder: Path) -> None:
    written = folder / WRITTEN
    if not written.is_dir():
        return
    for file in (path for path in written.rglob("*") if path.is_file()):
        place = folder / file.relative_to(written)
        place.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(place, file.read_bytes())
    shutil.rmtree(folder / UNFINISHED, ignore_errors=True)
    os.rename(written, folder / UNFINISHED)
    shutil.rmtree(folder / UNFINISHED)
