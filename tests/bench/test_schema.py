"""Rows and manifests of older schemas, on the files that were published with them."""

import json
import re
from dataclasses import fields
from pathlib import Path

import pytest

from benchmarks.conditions import TaskSpec
from benchmarks.manifest import FILE_NAME, Manifest, config_hash, read_manifest
from benchmarks.plan import plan_suite
from benchmarks.results import ROWS_NAME, read_rows
from benchmarks.rows import Row
from benchmarks.schema import SCHEMA
from benchmarks.suites import SUITES

PUBLISHED = Path(__file__).parents[2] / "benchmarks" / "published"
FOLDERS = sorted(path.parent for path in PUBLISHED.rglob(FILE_NAME))
ADDED = {"condition": "default", "repeat": 0, "buffer_overflows": None}


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_published_rows_are_read_without_loss(folder: Path) -> None:
    lines = (folder / ROWS_NAME).read_text(encoding="utf-8").splitlines()
    rows = read_rows(folder)
    assert len(rows) == len(lines) > 0
    for line, row in zip(lines, rows, strict=True):
        record = json.loads(line)
        if record["schema"] == 1:
            privileged = "unspecified" if record["privileged"] else ""
            record = {**record, **ADDED, "privileged": privileged, "schema": SCHEMA}
        assert json.loads(row.to_line()) == record


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_published_manifests_describe_their_rows(folder: Path) -> None:
    manifest = read_manifest(folder)
    assert manifest.mixed == ()
    planned = {job.key: job.seed for job in manifest.plan.jobs()}
    assert {row.key: row.seed for row in read_rows(folder)} == planned


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_published_manifests_hash_their_plan(folder: Path) -> None:
    manifest = read_manifest(folder)
    written = json.loads((folder / FILE_NAME).read_text(encoding="utf-8"))
    if written["schema"] >= 2:
        assert written["config"] == manifest.config == config_hash(manifest.plan)
    else:
        assert manifest.config == ""


def test_published_rows_of_a_suite_are_those_of_its_plan() -> None:
    suites = {suite.title: suite for suite in SUITES.values()}
    plans = [read_manifest(folder).plan for folder in FOLDERS]
    of_suites = [plan for plan in plans if plan.suite in suites]
    assert of_suites
    for plan in of_suites:
        assert plan == plan_suite(suites[plan.suite], plan.agents)


def test_there_is_a_manifest_of_the_first_schema() -> None:
    folder = PUBLISHED / "gates-ICDCableRouting-v0" / "rows" / "pc-mppi"
    assert json.loads((folder / FILE_NAME).read_text(encoding="utf-8"))["schema"] == 1
    manifest = read_manifest(folder)
    assert manifest.schema == SCHEMA
    assert manifest.tasks == (TaskSpec("ICDCableRouting-v0"),)
    assert (manifest.repeats, manifest.wall_seconds) == (1, None)


@pytest.mark.parametrize("kind", [Row, Manifest])
def test_every_field_is_documented(kind: type) -> None:
    documentation = (PUBLISHED.parents[1] / "docs" / "results.md").read_text(encoding="utf-8")
    table = documentation.split(f"## {'Rows' if kind is Row else 'Manifest'}: schema {SCHEMA}")[1]
    table = table.split("## ")[0]
    first_cells = re.findall(r"^\| (`.*?) \|", table, re.M)
    documented = {name for cell in first_cells for name in re.findall(r"`(\w+)`", cell)}
    assert documented == {field.name for field in fields(kind)}
