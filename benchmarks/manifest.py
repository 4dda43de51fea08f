"""What a results folder was made of: plan, versions, code and machine."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks import provenance
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.files import write_atomically
from benchmarks.plan import Plan
from benchmarks.rows import SCHEMA

FILE_NAME = "manifest.json"


@dataclass(frozen=True)
class Manifest:
    """Everything about a run that is the same for all of its rows.

    Attributes:
        schema: version of manifest and rows.
        agents: names, in the order of the tables.
        envs: ids, in the order of the tables.
        episodes: episodes for each agent and environment.
        seed: base seed.
        packages: installed versions.
        code: fingerprint of the sources and weights of envs, agents and baselines.
        commit: git commit of the checkout, if it is one.
        dirty: whether the checkout had uncommitted changes.
        python: its version.
        platform: operating system and architecture.
        cpu_count: cores this process may use.
        cpu_model: as the operating system calls it.
        created: when the folder was begun, UTC.
        updated: when it was last resumed, UTC.
    """

    schema: int
    agents: tuple[str, ...]
    envs: tuple[str, ...]
    episodes: int
    seed: int
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

    @property
    def plan(self) -> Plan:
        """The plan it describes."""
        return Plan(self.agents, self.envs, self.episodes, self.seed)

    def to_json(self) -> bytes:
        """The file's content."""
        return json.dumps(asdict(self), indent=2).encode()

    def write(self, folder: Path) -> None:
        """Replace the folder's manifest in one step."""
        write_atomically(folder / FILE_NAME, self.to_json())


def describe(plan: Plan) -> Manifest:
    """Manifest of a run that begins now, with this code on this machine."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    commit, dirty = provenance.git_state()
    return Manifest(
        schema=SCHEMA,
        agents=plan.agents,
        envs=plan.envs,
        episodes=plan.episodes,
        seed=plan.seed,
        packages=provenance.package_versions(),
        code=provenance.code_fingerprint(),
        commit=commit,
        dirty=dirty,
        python=provenance.python_version(),
        platform=provenance.platform_name(),
        cpu_count=provenance.cpu_count(),
        cpu_model=provenance.cpu_model(),
        created=now,
        updated=now,
    )


def read_manifest(folder: Path) -> Manifest:
    """Read a folder's manifest.

    Raises:
        ResultsError: missing or not a manifest.
        IncompatibleResultsError: of another schema version.
    """
    path = folder / FILE_NAME
    try:
        record: Any = json.loads(path.read_text(encoding="utf-8"))
        if record["schema"] != SCHEMA:
            raise IncompatibleResultsError(
                f"{path}: schema must be {SCHEMA}, got {record['schema']!r}: read it with the "
                "version of this project that wrote it"
            )
        return Manifest(
            **{**record, "agents": tuple(record["agents"]), "envs": tuple(record["envs"])}
        )
    except FileNotFoundError as error:
        raise ResultsError(f"no results in {folder}: {FILE_NAME} is missing there") from error
    except (OSError, ValueError, KeyError, TypeError) as error:
        if isinstance(error, ResultsError):
            raise
        raise ResultsError(f"{path} is not a manifest: {type(error).__name__}: {error}") from error


def continued(old: Manifest, new: Manifest) -> Manifest:
    """Manifest of ``old``'s folder once ``new`` has gone on with it.

    Raises:
        IncompatibleResultsError: the rows of the two would not be comparable.
    """
    differences = [
        f"{name}: {before!r} there, {now!r} now"
        for name, before, now in [
            ("base seed", old.seed, new.seed),
            ("code", old.code, new.code),
            *((name, old.packages.get(name), now) for name, now in new.packages.items()),
        ]
        if before != now
    ]
    if not new.plan.extends(old.plan):
        differences.append(
            f"plan: agents={list(old.agents)} envs={list(old.envs)} episodes={old.episodes} there "
            f"is not contained in agents={list(new.agents)} envs={list(new.envs)} "
            f"episodes={new.episodes} now"
        )
    if differences:
        raise IncompatibleResultsError(
            f"cannot resume: {'; '.join(differences)}. Choose another --out, or the same "
            "agents, envs, episodes (or more of them), seed, code and versions"
        )
    return replace(new, created=old.created)
