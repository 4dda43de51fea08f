"""Files that replace others all together: a kill leaves the old ones or the new ones."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

WRITTEN: Final = ".written"
"""Folder of files that are all written, but not yet all in their places."""
UNFINISHED: Final = ".unfinished"
"""Folder of files that are being written, or are in their places; what is left of it is void."""


@contextmanager
def replacing(folder: Path) -> Iterator[Path]:
    """Give a folder to write to; in the end its files replace those of the same names.

    Args:
        folder: where the files shall be in the end; made if it is missing, other files stay.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _put_in_place(folder)
    unfinished = folder / UNFINISHED
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir()
    try:
        yield unfinished
    except Exception:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise
    os.rename(unfinished, folder / WRITTEN)
    _put_in_place(folder)


def current(folder: Path) -> Path:
    """Where the files of a folder are now: beside their places if their writer was killed."""
    return folder / WRITTEN if (folder / WRITTEN).is_dir() else folder


def write_synced(path: Path, content: bytes) -> None:
    """Write a new file to the disk."""
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _put_in_place(folder: Path) -> None:
    written = folder / WRITTEN
    if not written.is_dir():
        return
    for file in (path for path in written.rglob("*") if path.is_file()):
        place = folder / file.relative_to(written)
        place.parent.mkdir(parents=True, exist_ok=True)
        beside = place.with_name(f"{place.name}.new")
        write_synced(beside, file.read_bytes())
        os.replace(beside, place)
    shutil.rmtree(folder / UNFINISHED, ignore_errors=True)
    os.rename(written, folder / UNFINISHED)
    shutil.rmtree(folder / UNFINISHED)
