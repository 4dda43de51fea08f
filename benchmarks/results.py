"""Results folders: one line per episode, a manifest, and a lock against a second writer."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

from benchmarks.errors import IncompatibleResultsError, ResultsError, ResultsWarning
from benchmarks.manifest import FILE_NAME as MANIFEST_NAME
from benchmarks.manifest import Manifest, continued, describe, read_manifest
from benchmarks.plan import JobKey, Plan
from benchmarks.rows import Row, row_from_record
from benchmarks.schema import READABLE, SCHEMA
from icd_agent.locking import alone

ROWS_NAME = "episodes.jsonl"


class ResultsFolder:
    """A locked folder that rows are appended to; made by ``open_results``."""

    def __init__(self, path: Path, rows: list[Row]) -> None:
        """Take over rows that are there already."""
        self._path = path
        self.rows = rows

    def append(self, row: Row) -> None:
        """Add a row; it is on disk, whole, when this returns.

        Raises:
            ResultsError: the file system did not take it.
        """
        line = row.to_line().encode()
        path = self._path / ROWS_NAME
        try:
            with path.open("ab", buffering=0) as file:
                written = file.write(line)
                os.fsync(file.fileno())
        except OSError as error:
            raise ResultsError(f"cannot write {path}: {error}") from error
        if written != len(line):
            raise ResultsError(f"cannot write {path}: disk full? free some space and --resume")
        self.rows.append(row)


@contextmanager
def open_results(
    path: Path,
    plan: Plan,
    *,
    resume: bool,
    settings: Mapping[str, str | float] | None = None,
    allow_mixed: bool = False,
    retry_errors: bool = False,
) -> Iterator[ResultsFolder]:
    """Open a folder for writing the rows of a plan, alone.

    Args:
        path: the folder; made if missing.
        plan: what will be run.
        resume: go on with results that are there; otherwise they are an error.
        settings: what else decides how episodes end.
        allow_mixed: go on even with other settings, code or versions; the manifest tells.
        retry_errors: errors of the plan are not among the rows, and stay in the file; the manifest
            tells how many there were.

    Raises:
        ResultsError: not writable, in use, or unexpected results.
        IncompatibleResultsError: results of another plan, code or version.
    """
    with alone(path, "run", ResultsError):
        begun = describe(plan, settings)
        manifest, rows = _begin(path, begun, resume=resume, allow_mixed=allow_mixed)
        if retry_errors:
            manifest, rows = _without_errors(manifest, rows)
            manifest.write(path)
        start = perf_counter()
        try:
            yield ResultsFolder(path, rows)
        finally:
            seconds = (manifest.wall_seconds or 0.0) + perf_counter() - start
            with suppress(OSError):  # the rows matter more than how long they took
                replace(manifest, wall_seconds=seconds).write(path)


def new_folder(parent: Path) -> Path:
    """Make a folder named after the present time, UTC."""
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in range(1, 100):
            path = parent / (stamp if number == 1 else f"{stamp}-{number}")
            try:
                path.mkdir()
            except FileExistsError:
                continue
            return path
    except OSError as error:
        raise ResultsError(f"cannot write to {parent}: {error}: choose an --out") from error
    raise ResultsError(f"too many runs started at {stamp} in {parent}: choose an --out")


def read_rows(path: Path) -> list[Row]:
    """Read all rows of a folder, in the order of writing, each job once.

    An error gives way to what came of its job when it was run again. A last line that was torn by a
    crash is left out with a ``ResultsWarning``.

    Raises:
        ResultsError: a line is no row, or two rows of one job disagree; names file and line.
        IncompatibleResultsError: a row of another schema version.
    """
    return _unique(path / ROWS_NAME, _parse(path / ROWS_NAME, _read_lines(path / ROWS_NAME)))


def _begin(
    path: Path, manifest: Manifest, *, resume: bool, allow_mixed: bool
) -> tuple[Manifest, list[Row]]:
    try:
        if any((path / name).exists() for name in (MANIFEST_NAME, ROWS_NAME)):
            if not resume:
                raise ResultsError(
                    f"{path} has results already: go on with --resume, or choose another --out"
                )
            manifest = continued(read_manifest(path), manifest, allow_mixed=allow_mixed)
            rows = read_rows(path)
            _mend_tail(path / ROWS_NAME)
        else:
            rows = []
        manifest.write(path)
    except OSError as error:
        raise ResultsError(f"cannot write to {path}: {error}: choose another --out") from error
    return manifest, rows


def _without_errors(manifest: Manifest, rows: list[Row]) -> tuple[Manifest, list[Row]]:
    jobs = {job.key for job in manifest.plan.jobs()}
    kept = [row for row in rows if row.status == "ok" or row.key not in jobs]
    if (again := len(rows) - len(kept)) > 0:
        note = f"{again} with an error run again on {manifest.updated}"
        manifest = replace(manifest, mixed=(*manifest.mixed, note))
    return manifest, kept


def _read_lines(file: Path) -> list[bytes]:
    try:
        return file.read_bytes().split(b"\n")
    except FileNotFoundError:
        return []
    except OSError as error:
        raise ResultsError(f"cannot read {file}: {error}") from error


def _parse(file: Path, lines: list[bytes]) -> Iterator[tuple[int, Row]]:
    """Yield line numbers and rows."""
    last = max((number for number, line in enumerate(lines, 1) if line.strip()), default=0)
    for number, line in enumerate(lines[:last], 1):
        try:
            record = json.loads(line)
        except (ValueError, RecursionError) as error:
            if number == last:
                warnings.warn(
                    f"{file}, line {number}: left out, torn by a crash", ResultsWarning, 2
                )
                return
            raise ResultsError(f"{file}, line {number}: not JSON: {error}") from error
        if isinstance(record, dict) and record.get("schema", SCHEMA) not in READABLE:
            raise IncompatibleResultsError(
                f"{file}, line {number}: schema must be one of {READABLE}, got "
                f"{record['schema']!r}: read it with the version of this project that wrote it"
            )
        try:
            yield number, row_from_record(record)
        except (ValueError, TypeError, OverflowError) as error:
            raise ResultsError(f"{file}, line {number}: {error}") from error


def _unique(file: Path, numbered: Iterable[tuple[int, Row]]) -> list[Row]:
    seen: dict[JobKey, tuple[int, Row]] = {}
    for number, row in numbered:
        first, other = seen.setdefault(row.key, (number, row))
        if other.status == "error":
            seen[row.key] = (number, row)
        elif row.without_times() != other.without_times():
            raise ResultsError(
                f"{file}, lines {first} and {number}: two different rows for "
                f"agent={row.agent!r} env={row.env!r} index={row.index}: delete the wrong one"
            )
    return [row for _, row in seen.values()]


def _mend_tail(file: Path) -> None:
    """Cut a torn last line off, so that the next row begins a line of its own."""
    lines = _read_lines(file)
    while lines and not lines[-1].strip():
        lines.pop()
    if not lines:
        return
    try:
        json.loads(lines[-1])
    except ValueError:
        lines.pop()
    size = sum(len(line) + 1 for line in lines)
    with file.open("r+b") as rows:
        rows.truncate(size)
        rows.seek(max(0, size - 1))
        rows.write(b"\n" if size else b"")
