"""icd-bench report: what goes where."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import Result
from typer.testing import CliRunner

from benchmarks.cli import main
from benchmarks.manifest import read_manifest
from tests.bench.making import make_row, make_rows, save


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return save(tmp_path / "räw rows", make_rows("a", [True, False]) + make_rows("b", [True, True]))


def report(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["report", *map(str, arguments)])


def test_files_are_written_and_the_table_is_printed(folder: Path, tmp_path: Path) -> None:
    made = report(folder, "--html", tmp_path / "page.html", "--csv", tmp_path / "rows.csv")
    assert made.exit_code == 0, made.stderr
    assert "1/2" in made.stdout
    assert (tmp_path / "page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    with (tmp_path / "rows.csv").open(encoding="utf-8", newline="") as file:
        assert [row["agent"] for row in csv.DictReader(file)] == ["a", "a", "b", "b"]


@pytest.mark.parametrize(
    ("flag", "start"), [("--json", "[{"), ("--markdown", "### E-v0"), ("--latex", "% needs")]
)
def test_form_on_stdout(folder: Path, flag: str, start: str) -> None:
    made = report(folder, flag)
    assert made.exit_code == 0, made.stderr
    assert start in made.stdout
    assert "┏" not in made.stdout


def test_json_is_what_it_was(folder: Path) -> None:
    assert [record["success"] for record in json.loads(report(folder, "--json").stdout)] == [0.5, 1]


def test_warnings_are_below_the_table(tmp_path: Path) -> None:
    out = report(save(tmp_path, [make_row(status="error", message="boom")])).stdout
    assert "note: 1 episode with an error, which no rate counts" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--json", "--latex"], "choose one"),
        (["--videos", "some"], "'first', 'failures', 'all'"),
        (["--html", "no/such/folder/page.html"], "cannot write no/such/folder/page.html"),
    ],
)
def test_usage_errors_exit_2(folder: Path, arguments: list[str], message: str) -> None:
    refused = report(folder, *arguments)
    assert refused.exit_code == 2
    assert message in " ".join(refused.stderr.replace("│", " ").split())


def test_mixed_runs_are_flagged_in_every_form(folder: Path, tmp_path: Path) -> None:
    mixed = "numpy: '1' there, '2' now"
    replace(read_manifest(folder), mixed=(mixed,)).write(folder)
    page = tmp_path / "page.html"
    assert f"its runs differ: {mixed}" in report(folder, "--html", page).stdout
    assert "its runs differ: numpy" in page.read_text(encoding="utf-8")
    assert f"its runs differ: {mixed}" in report(folder, "--markdown").stdout
    assert f"its runs differ: {mixed}" in report(folder, "--latex").stdout
