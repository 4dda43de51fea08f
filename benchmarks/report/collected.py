"""The rows of one or more results folders, joined, and what a reader must know of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.conditions import TaskSpec
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.manifest import Manifest, read_manifest
from benchmarks.plan import Job
from benchmarks.results import read_rows
from benchmarks.rows import Row


@dataclass(frozen=True)
class Found:
    """A row and the folder it is from.

    Attributes:
        folder: of the results.
        row: an episode.
    """

    folder: Path
    row: Row


@dataclass(frozen=True)
class Collected:
    """Everything that a report is made from.

    Attributes:
        folders: as they were named.
        manifests: of each folder.
        found: every episode once, in the order of folders and rows.
        outdone: errors in one folder that another folder has a result for.
    """

    folders: tuple[Path, ...]
    manifests: tuple[Manifest, ...]
    found: tuple[Found, ...]
    outdone: int = 0

    @property
    def rows(self) -> list[Row]:
        """Every episode once."""
        return [found.row for found in self.found]

    @property
    def tasks(self) -> list[TaskSpec]:
        """Of all manifests, in their order."""
        return list(dict.fromkeys(task for manifest in self.manifests for task in manifest.tasks))

    def agents_of(self, task: TaskSpec) -> list[str]:
        """Agents that were to run on a task, in the manifests' order."""
        return list(
            dict.fromkeys(
                agent
                for manifest in self.manifests
                if task in manifest.tasks
                for agent in manifest.agents
            )
        )

    def rows_of(self, task: TaskSpec) -> dict[str, list[Row]]:
        """Rows of a task by agent; agents without any are there too."""
        rows: dict[str, list[Row]] = {agent: [] for agent in self.agents_of(task)}
        for found in self.found:
            if (found.row.env, found.row.condition) == task.key:
                rows.setdefault(found.row.agent, []).append(found.row)
        return rows

    def warnings(self) -> list[str]:
        """What makes these results less than a clean run of one version of the code."""
        return list(self._warnings())

    def _warnings(self) -> Iterator[str]:
        for folder, manifest in zip(self.folders, self.manifests, strict=True):
            if manifest.mixed:
                yield f"{folder}: its runs differ: {'; '.join(manifest.mixed)}"
            if manifest.dirty:
                yield f"{folder}: the code had changes that were not committed"
        if len({manifest.code for manifest in self.manifests}) > 1:
            yield "the folders were made with different code"
        for what in ("packages", "settings", "weights"):
            records = [getattr(manifest, what) for manifest in self.manifests]
            if names := _disagreeing(records):
                yield f"the folders were made with different {what}: {', '.join(names)}"
        planned = {_episode(job) for manifest in self.manifests for job in manifest.plan.jobs()}
        if missing := planned - {_episode(found.row) for found in self.found}:
            yield f"unfinished: {len(missing)} of {len(planned)} planned episodes are missing"
        if self.outdone:
            yield (
                f"{counted(self.outdone, 'episode')} with an error in one folder count as they "
                "ended in another"
            )
        if errors := sum(found.row.status == "error" for found in self.found):
            yield f"{counted(errors, 'episode')} with an error, which no rate counts"


def collect(folders: Sequence[Path]) -> Collected:
    """Read and join folders.

    Raises:
        ResultsError: a folder cannot be read, or two folders disagree about an episode.
        IncompatibleResultsError: a folder of another schema version, or two that mean different
            things by one condition.
    """
    manifests = tuple(read_manifest(folder) for folder in folders)
    _check_conditions(task for manifest in manifests for task in manifest.tasks)
    found = [Found(folder, row) for folder in folders for row in read_rows(folder)]
    errors = {_episode(one.row) for one in found if one.row.status == "error"}
    merged = _merge(found)
    outdone = errors - {_episode(one.row) for one in merged if one.row.status == "error"}
    return Collected(tuple(folders), manifests, tuple(merged), len(outdone))


def _disagreeing(records: Iterable[Mapping[str, object]]) -> list[str]:
    """Names under which two records that have them say different things."""
    seen: dict[str, object] = {}
    names = [
        name for record in records for name, value in record.items()
        if seen.setdefault(name, value) != value
    ]  # fmt: skip
    return list(dict.fromkeys(names))


def counted(n: int, thing: str) -> str:
    """A number of things."""
    return f"{n} {thing}{'' if n == 1 else 's'}"


def _check_conditions(tasks: Iterable[TaskSpec]) -> None:
    seen: dict[tuple[str, str], TaskSpec] = {}
    for task in tasks:
        if seen.setdefault(task.key, task) != task:
            raise IncompatibleResultsError(
                f"condition {task.condition.name!r} of {task.env!r} means "
                f"{seen[task.key].condition.record()} in one folder and "
                f"{task.condition.record()} in another: report them one by one"
            )


def _episode(of: Row | Job) -> tuple[str, str, str, int, int]:
    """What makes an episode the same in every folder; numbers depend on the base seed."""
    agent, env, condition, _, repeat = of.key
    return (agent, env, condition, of.seed, repeat)


def _merge(found: Iterable[Found]) -> list[Found]:
    """All rows; an episode that several folders hold counts once, and not as an error if it can."""
    seen: dict[tuple[str, str, str, int, int], Found] = {}
    for one in found:
        row, other = one.row, seen.setdefault(_episode(one.row), one)
        ok = row.status == other.row.status == "ok"
        if ok and row.outcome != other.row.outcome:
            raise ResultsError(
                f"{other.folder} and {one.folder} disagree about agent={row.agent!r} "
                f"env={row.env!r} condition={row.condition!r} seed={row.seed}: report them "
                "one by one"
            )
        if other.row.status == "error":
            seen[_episode(row)] = one
    return list(seen.values())
