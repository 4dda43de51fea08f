"""Versions of rows and manifests, and how older ones are read; see docs/results.md."""

from __future__ import annotations

from typing import Any, Final

SCHEMA: Final = 2
"""Rises when a field is added, dropped or changes its meaning."""
READABLE: Final = (1, SCHEMA)

Record = dict[str, Any]


def upgraded_row(record: Record) -> Record:
    """A row of this schema from a record of this or an older one; others are left as they are."""
    if record.get("schema") == 1:
        known = {"condition": "default", "repeat": 0, "buffer_overflows": None}
        privileged = "unspecified" if record.get("privileged") else ""
        return {**record, **known, "privileged": privileged, "schema": SCHEMA}
    return record


def upgraded_manifest(record: Record) -> Record:
    """The same for a manifest."""
    if record.get("schema") == 1:
        kept = {name: value for name, value in record.items() if name != "envs"}
        tasks = [{"env": env, "condition": {"options": {}}} for env in record["envs"]]
        new = {"repeats": 1, "suite": "", "config": "", "weights": {}, "wall_seconds": None}
        return {**kept, **new, "tasks": tasks, "mixed": [], "schema": SCHEMA}
    return record
