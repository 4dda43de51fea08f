"""Whatever moment a writer is killed at, what is there is all old or all new."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from icd_agent.replacing import current, replacing, write_synced
from icd_envs.errors import CheckpointError
from tests.killing import KilledError

NAMES = ("config", "part/config", "part/weights")


def write(folder: Path, content: bytes) -> None:
    with replacing(folder) as new:
        (new / "part").mkdir()
        for name in NAMES:
            write_synced(new / name, content)


def contents(folder: Path) -> set[bytes]:
    return {(folder / name).read_bytes() for name in NAMES}


def test_a_kill_at_any_moment_leaves_the_old_files_or_the_new_ones(tmp_path: Path) -> None:
    left: list[set[bytes]] = []
    for moment in range(100):
        folder = tmp_path / str(moment)
        write(folder, b"old")
        try:
            with killed_at(moment):
                write(folder, b"new")
        except KilledError:
            left.append(contents(current(folder)))
        else:
            break
        write(folder, b"newer")
        assert contents(folder) == {b"newer"}
        assert sorted(path.name for path in folder.iterdir()) == ["config", "part"]
    assert len(left) > 8
    changed = left.index({b"new"})
    assert left == [{b"old"}] * changed + [{b"new"}] * (len(left) - changed)
    assert 0 < changed < len(left)


class killed_at:  # noqa: N801  reads as a phrase
    """Kill at the n-th thing that is done to the disk."""

    def __init__(self, moment: int) -> None:
        self._left = moment
        self._patched = pytest.MonkeyPatch()

    def __enter__(self) -> None:
        for module, name in ((os, "fsync"), (os, "rename"), (os, "replace"), (shutil, "rmtree")):
            self._patched.setattr(module, name, self._counted(getattr(module, name)))

    def __exit__(self, *error: object) -> None:
        self._patched.undo()

    def _counted(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*arguments: Any, **named: Any) -> Any:  # noqa: ANN401
            if self._left == 0:
                raise KilledError
            self._left -= 1
            return function(*arguments, **named)

        return counted


def test_other_files_stay_and_a_failure_leaves_nothing(tmp_path: Path) -> None:
    write(tmp_path, b"old")
    (tmp_path / "part" / "log").write_text("mine")
    with pytest.raises(CheckpointError, match="cannot write"), replacing(tmp_path) as new:
        write_synced(new / "no folder" / "config", b"new")
    assert contents(tmp_path) == {b"old"}
    write(tmp_path, b"new")
    assert (tmp_path / "part" / "log").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["config", "part"]
