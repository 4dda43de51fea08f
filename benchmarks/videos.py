"""Where the videos of a results folder are, and which of them a report shows."""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

from benchmarks.errors import ResultsError
from benchmarks.plan import JobKey
from benchmarks.rows import Row
from icd_agent.replacing import write_atomically

FOLDER_NAME: Final = "videos"

Choice = Literal["first", "failures", "all"]


def video_path(folder: Path, key: JobKey) -> Path:
    """``videos/<agent>/<env>/<condition>/<index>-<repeat>.mp4`` below a results folder.

    Args:
        folder: of the results.
        key: of a job or row; names become safe file names, different ones stay different.
    """
    *names, index, repeat = key
    return folder.joinpath(FOLDER_NAME, *map(_safe, map(str, names)), f"{index:05d}-{repeat}.mp4")


def save_video(folder: Path, key: JobKey, content: bytes) -> None:
    """Put the video of an episode in its place, whole.

    Raises:
        ResultsError: the file system did not take it.
    """
    path = video_path(folder, key)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, content)
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error}") from error


def wanted(rows: Sequence[Row], choice: Choice) -> list[Row]:
    """Rows whose videos are asked for: each agent's first episode of a task, its failures, all.

    ``failures`` are episodes without success, errors included.
    """
    if choice == "all":
        return list(rows)
    if choice == "failures":
        return [row for row in rows if not row.success]
    in_order = sorted(rows, key=lambda row: (row.repeat, row.index))
    first = {(row.agent, row.env, row.condition): row for row in reversed(in_order)}
    return [row for row in rows if first[row.agent, row.env, row.condition] is row]


def _safe(name: str) -> str:
    plain = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip(".-")[:80]
    return plain if plain and plain == name else f"{plain}-{zlib.crc32(name.encode()):08x}"
