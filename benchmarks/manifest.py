"""What a results folder was made of: plan, versions, code and machine."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from types import NoneType
from typing import Any, Final

from benchmarks import provenance
from benchmarks.conditions import TaskSpec, task_from_record
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.plan import Plan
from benchmarks.schema import READABLE, SCHEMA, upgraded_manifest
from icd_agent.replacing import write_atomically

FILE_NAME = "manifest.json"


@dataclass(frozen=True)
class Manifest:
    """Everything about a run that is the same for all of its rows.

    Attributes:
        schema: version of manifest and rows.
        agents: names, in the order of the tables.
        tasks: environments and conditions, in the order of the tables.
        episodes: test cases for each agent and task.
        repeats: episodes for each test case.
        seed: base seed.
        suite: name and version, if the plan is exactly a suite's.
        config: hash of the plan; empty if it was not recorded.
        weights: hashes of the weight files, by path.
        packages: installed versions.
        code: fingerprint of the sources and weights of envs, agents and baselines.
        commit: git commit of the checkout, if it is one.
        dirty: whether our packages in it had uncommitted changes, in any of the runs.
        python: its version.
        platform: operating system and architecture.
        cpu_count: cores this process may use.
        cpu_model: as the operating system calls it.
        created: when the folder was begun, UTC.
        updated: when it was last resumed, UTC.
        wall_seconds: [s] that its runs took together; None if it was not recorded.
        settings: what else decides how episodes end: budgets of time, device, and the files that
            agents from elsewhere come from.
        mixed: in what the runs that wrote the rows differ: what had to be allowed, Python and
            processor, and errors that were run again.
    """

    schema: int
    agents: tuple[str, ...]
    tasks: tuple[TaskSpec, ...]
    episodes: int
    repeats: int
    seed: int
    suite: str
    config: str
    weights: dict[str, str]
    packages: dict[str, str]
    code: str
    commit: str | None
    dirty: bool | None
    python: str
    platform: str
    cpu_count: int
    cpu_model: str
    created: str
    updated: str
    wall_seconds: float | None = 0.0
    settings: dict[str, str | float] = field(default_factory=dict)
    mixed: tuple[str, ...] = ()

    @property
    def plan(self) -> Plan:
        """The plan it describes."""
        return Plan(self.agents, self.tasks, self.episodes, self.seed, self.repeats, self.suite)

    def to_json(self) -> bytes:
        """The file's content."""
        record = {**vars(self), "tasks": [task.record() for task in self.tasks]}
        return json.dumps(record, indent=2).encode()

    def write(self, folder: Path) -> None:
        """Replace the folder's manifest in one step."""
        write_atomically(folder / FILE_NAME, self.to_json())


def describe(plan: Plan, settings: Mapping[str, str | float] | None = None) -> Manifest:
    """Manifest of a run that begins now, with this code on this machine."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    commit, dirty = provenance.git_state()
    return Manifest(
        schema=SCHEMA,
        agents=plan.agents,
        tasks=plan.tasks,
        episodes=plan.episodes,
        repeats=plan.repeats,
        seed=plan.seed,
        suite=plan.suite,
        config=config_hash(plan),
        weights=provenance.weight_hashes(),
        packages=provenance.package_versions(),
        code=provenance.code_fingerprint(),
        commit=commit,
        dirty=dirty,
        python=platform.python_version(),
        platform=platform.platform(),
        cpu_count=provenance.cpu_count(),
        cpu_model=provenance.cpu_model(),
        created=now,
        updated=now,
        settings=dict(settings or {}),
    )


def config_hash(plan: Plan) -> str:
    """Hash of everything that a plan says."""
    record = {**vars(plan), "tasks": [task.record() for task in plan.tasks]}
    return f"sha256:{hashlib.sha256(json.dumps(record).encode()).hexdigest()}"


def read_manifest(folder: Path) -> Manifest:
    """Read a folder's manifest, of this schema or an older one.

    Raises:
        ResultsError: missing or not a manifest.
        IncompatibleResultsError: of another schema version.
    """
    path = folder / FILE_NAME
    try:
        record: Any = upgraded_manifest(json.loads(path.read_text(encoding="utf-8")))
        if record["schema"] != SCHEMA:
            raise IncompatibleResultsError(
                f"{path}: schema must be one of {READABLE}, got {record['schema']!r}: "
                "read it with the version of this project that wrote it"
            )
        listed = {name: tuple(record[name]) for name in ("agents", "mixed")}
        tasks = tuple(map(task_from_record, record["tasks"]))
        manifest = Manifest(**{**record, **listed, "tasks": tasks})
        _check(manifest)
        return manifest
    except FileNotFoundError as error:
        raise ResultsError(f"no results in {folder}: {FILE_NAME} is missing there") from error
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        if isinstance(error, ResultsError):
            raise
        raise ResultsError(f"{path} is not a manifest: {type(error).__name__}: {error}") from error


_KINDS: Final[dict[str, tuple[type, ...]]] = {
    **dict.fromkeys(("schema", "episodes", "repeats", "seed", "cpu_count"), (int,)),
    **dict.fromkeys(("suite", "config", "code", "python", "platform"), (str,)),
    **dict.fromkeys(("cpu_model", "created", "updated"), (str,)),
    "commit": (str, NoneType),
    "dirty": (bool, NoneType),
    "wall_seconds": (int, float, NoneType),
}
_TEXTS: Final = ("agents", "mixed")
_RECORDS: Final[dict[str, tuple[type, ...]]] = {
    "weights": (str,),
    "packages": (str,),
    "settings": (str, int, float),
}


def _check(manifest: Manifest) -> None:
    """Refuse values of a wrong type.

    Raises:
        TypeError: names the field.
    """
    kinds = {**_KINDS, **dict.fromkeys(_TEXTS, (tuple,)), **dict.fromkeys(_RECORDS, (dict,))}
    for name, allowed in kinds.items():
        value = getattr(manifest, name)
        if type(value) not in allowed:
            raise TypeError(f"{name} must be {_or(allowed)}, got {value!r}")
    for name, allowed in {**dict.fromkeys(_TEXTS, (str,)), **_RECORDS}.items():
        value = getattr(manifest, name)
        items = value.values() if isinstance(value, dict) else value
        if any(type(item) not in allowed for item in items):
            raise TypeError(f"{name} must hold {_or(allowed)} only, got {value!r}")


def _or(kinds: tuple[type, ...]) -> str:
    return " or ".join(kind.__name__ for kind in kinds)


def continued(old: Manifest, new: Manifest, *, allow_mixed: bool = False) -> Manifest:
    """Manifest of ``old``'s folder once ``new`` has gone on with it.

    Args:
        old: of the folder.
        new: of this run.
        allow_mixed: accept other settings, code and versions, and say so in the manifest.

    Raises:
        IncompatibleResultsError: the rows of the two would not be comparable.
    """
    fix = "choose another --out, or the same agents, envs, episodes (or more of them) and seed"
    if old.seed != new.seed:
        raise IncompatibleResultsError(
            f"cannot resume: base seed: {old.seed} there, {new.seed} now: {fix}"
        )
    if not new.plan.extends(old.plan):
        raise IncompatibleResultsError(
            f"cannot resume: plan: {_described(old.plan)} there is not contained in "
            f"{_described(new.plan)} now: {fix}"
        )
    differences = tuple(what_differs(old, new))
    if differences and not allow_mixed:
        raise IncompatibleResultsError(
            f"cannot resume: {'; '.join(differences)}: choose another --out, or --allow-mixed "
            "where there is one, which every report will flag"
        )
    machines = [
        ("python", old.python, new.python),
        ("processor", old.cpu_model, new.cpu_model),
    ]
    return replace(
        new,
        created=old.created,
        dirty=old.dirty or new.dirty,
        wall_seconds=old.wall_seconds,
        settings={**old.settings, **new.settings},
        mixed=tuple(dict.fromkeys((*old.mixed, *differences, *_differing(machines)))),
    )


def what_differs(old: Manifest, new: Manifest) -> Iterator[str]:
    """What both know and do not agree on; agents that are new have no other past."""
    pairs = [
        ("code", old.code, new.code),
        *((name, old.packages.get(name, now), now) for name, now in new.packages.items()),
        *((name, old.settings.get(name, now), now) for name, now in new.settings.items()),
    ]
    return _differing(pairs)


def _differing(pairs: Iterable[tuple[str, object, object]]) -> Iterator[str]:
    for name, before, now in pairs:
        if before != now:
            yield f"{name}: {before!r} there, {now!r} now"


def _described(plan: Plan) -> str:
    tasks = [" ".join(task.key) for task in plan.tasks]
    return (
        f"agents={list(plan.agents)} tasks={tasks} repeats={plan.repeats} episodes={plan.episodes}"
    )
