"""Arrays on disk that are filled episode by episode, with a record of how far."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.lib.format import open_memmap
from numpy.typing import NDArray

from icd_agent.replacing import cannot_write, write_atomically
from icd_envs.errors import DemonstrationsError

PROGRESS: Final = "states.json"
OF_STATES: Final = {"features": np.float16, "clouds": np.float32}
"""Arrays (S, N, ...) with a row for every state."""
OF_EPISODES: Final = {"places": np.float32, "scene": np.float32}
"""Arrays (E, A, ...) with a row for every episode."""
KINDS: Final = {**OF_STATES, **OF_EPISODES}

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Kept:
    """A folder of ``KINDS``.

    Attributes:
        folder: where it is.
        identity: JSON, what the arrays depend on; those of something else are refused.
        episodes: E in all.
        states: S in all.
        points: N of the object.
    """

    folder: Path
    identity: Mapping[str, Any]
    episodes: int
    states: int
    points: int

    def done(self) -> int:
        """Episodes that are there.

        Raises:
            DemonstrationsError: the record is damaged, or of something else.
        """
        path = self.folder / PROGRESS
        if not path.exists():
            return 0
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
            done = record.pop("done")
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
            raise self._damaged(path, f"{type(error).__name__}: {error}") from error
        if record != self.identity:
            raise DemonstrationsError(
                f"{self.folder} has features of other states or of another space: delete it, or "
                "name another"
            )
        if type(done) is not int or not 0 <= done <= self.episodes:
            raise self._damaged(path, f"done={done!r}, not one of 0 to {self.episodes}")
        return done

    def create(self, rows: Mapping[str, tuple[int, ...]]) -> Arrays:
        """New arrays, whose space on the disk is theirs from now on.

        Args:
            rows: shape of a row, by name.

        Raises:
            DemonstrationsError: the disk has no room for them; none is left.
        """
        paths = {name: self._path(name) for name in KINDS}
        try:
            arrays: Arrays = {
                name: open_memmap(path, "w+", KINDS[name], (self._rows(name), *rows[name]))
                for name, path in paths.items()
            }
            for path in paths.values():
                _allocate(path)
        except OSError as error:
            for path in paths.values():
                path.unlink(missing_ok=True)
            size = sum(
                np.dtype(kind).itemsize * self._rows(name) * int(np.prod(rows[name]))
                for name, kind in KINDS.items()
            )
            raise DemonstrationsError(
                f"{self.folder} needs {size / 1e9:.3f} GB: {cannot_write(self.folder, error)}"
            ) from error
        return arrays

    def reopen(self, rows: Mapping[str, tuple[int, ...]]) -> Arrays:
        """The arrays of a killed call, to go on with.

        Args:
            rows: shape of a row, by name.

        Raises:
            DemonstrationsError: missing, damaged, or of other shapes.
        """
        for name, array in self.read().items():  # writable, one that is cut off would grow zeros
            if array.shape[1:] != rows[name]:
                raise self._damaged(self._path(name), f"rows of {array.shape[1:]}")
        return {name: open_memmap(self._path(name), "r+") for name in KINDS}

    def read(self) -> Arrays:
        """The arrays, on disk.

        Raises:
            DemonstrationsError: missing, damaged, or of other shapes.
        """
        arrays: Arrays = {}
        for name, kind in KINDS.items():
            path = self._path(name)
            try:
                array = open_memmap(path, "r")
            except (OSError, ValueError, EOFError) as error:
                raise self._damaged(path, f"{type(error).__name__}: {error}") from error
            fits = array.ndim == 3 and len(array) == self._rows(name) and array.dtype == kind
            if not fits or (name in OF_STATES and array.shape[1] != self.points):
                raise self._damaged(path, f"shape {array.shape} of {array.dtype}")
            arrays[name] = array
        return arrays

    def save(self, arrays: Mapping[str, NDArray[Any]], done: int) -> None:
        """Put what was filled on the disk, and record how far it is.

        Raises:
            DemonstrationsError: the disk did not take it; the record is that of before.
        """
        path = self.folder / PROGRESS
        try:
            for array in arrays.values():
                assert isinstance(array, np.memmap)
                array.flush()
            write_atomically(path, json.dumps({**self.identity, "done": done}).encode())
        except OSError as error:
            raise DemonstrationsError(cannot_write(path, error)) from error

    def _path(self, name: str) -> Path:
        return self.folder / f"{name}.npy"

    def _rows(self, name: str) -> int:
        return self.states if name in OF_STATES else self.episodes

    def _damaged(self, path: Path, why: str) -> DemonstrationsError:
        return DemonstrationsError(
            f"{path} is missing or damaged: {why}: delete {self.folder}, it is made again"
        )


def _allocate(path: Path) -> None:
    """Give a file of holes its space, where that is possible: a map cannot say that a disk is full.

    Raises:
        OSError: there is none.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    with path.open("r+b") as file:
        try:
            os.posix_fallocate(file.fileno(), 0, path.stat().st_size)
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL):  # not on this file system
                raise
