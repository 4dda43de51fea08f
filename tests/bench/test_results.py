"""Lines, manifests and locks of a results folder."""

import contextlib
import dataclasses
import json
import re
import time
import warnings
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks import manifest as manifests
from benchmarks.conditions import TaskSpec
from benchmarks.errors import IncompatibleResultsError, ResultsError, ResultsWarning
from benchmarks.manifest import continued, describe, read_manifest
from benchmarks.plan import Plan
from benchmarks.results import ROWS_NAME, new_folder, open_results, read_rows
from benchmarks.rows import row_from_record
from tests.bench.making import make_row

PLAN = Plan(agents=("a",), tasks=(TaskSpec("E-v0"),), episodes=3)
LINES = [make_row(index=index).to_line() for index in range(3)]


def write(folder: Path, text: str) -> Path:
    (folder / ROWS_NAME).write_text(text, encoding="utf-8")
    return folder


def test_rows_survive_the_file(tmp_path: Path) -> None:
    rows = [make_row(index=i, message='ünï "quoted"\n') for i in range(3)]
    with open_results(tmp_path / "späce d", PLAN, resume=False) as folder:
        for row in rows:
            folder.append(row)
        assert folder.rows == rows
    assert read_rows(tmp_path / "späce d") == rows
    assert read_rows(tmp_path / "nowhere") == []


def test_every_row_carries_the_schema(tmp_path: Path) -> None:
    assert json.loads(LINES[0])["schema"] == 2
    assert row_from_record(json.loads(LINES[0])) == make_row(index=0)


@pytest.mark.parametrize("tail", ['{"schema": 1, "agent": "a", "ind', "\x00\x00\x00", '{"a"\n'])
def test_torn_last_line_is_dropped_with_a_warning_and_resumable(tmp_path: Path, tail: str) -> None:
    write(tmp_path, LINES[0] + tail)
    describe(PLAN).write(tmp_path)
    with pytest.warns(ResultsWarning, match="line 2: left out"):
        assert [row.index for row in read_rows(tmp_path)] == [0]
    with (
        pytest.warns(ResultsWarning, match="line 2"),
        open_results(tmp_path, PLAN, resume=True) as folder,
    ):
        folder.append(make_row(index=1))
    assert [row.index for row in read_rows(tmp_path)] == [0, 1]


def test_whole_last_line_without_newline_is_kept(tmp_path: Path) -> None:
    write(tmp_path, LINES[0] + LINES[1].rstrip("\n"))
    describe(PLAN).write(tmp_path)
    with open_results(tmp_path, PLAN, resume=True) as folder:
        folder.append(make_row(index=2))
    assert [row.index for row in read_rows(tmp_path)] == [0, 1, 2]


@pytest.mark.parametrize(
    ("garbage", "reason"),
    [
        ("hello", "line 2: not JSON"),
        ("", "line 2: not JSON"),
        ("[1, 2]", "line 2: expected a JSON object"),
        ('{"schema": 1}', "line 2: missing or unknown fields: act_seconds, agent"),
        (LINES[1].replace("0.5", "NaN"), "line 2: complete must be a finite float, got nan"),
        (LINES[1].replace("0.5", "1.5"), r"line 2: complete must be in \[0, 1\]"),
        (LINES[1].replace('"ok"', '"fine"'), "line 2: status must be"),
        (LINES[1].replace('"steps": 10', '"steps": "10"'), "line 2: steps must be a finite int"),
        (LINES[1].replace('"index": 1', '"index": true'), "line 2: index must be a finite int"),
    ],
)
def test_garbage_in_the_middle_is_an_error_naming_the_line(
    tmp_path: Path, garbage: str, reason: str
) -> None:
    write(tmp_path, LINES[0] + garbage.rstrip("\n") + "\n" + LINES[2])
    with pytest.raises(ResultsError, match=f"{re.escape(ROWS_NAME)}, {reason}"):
        read_rows(tmp_path)


def test_rows_of_an_unknown_schema_are_incompatible(tmp_path: Path) -> None:
    write(tmp_path, LINES[0].replace('"schema": 2', '"schema": 3'))
    with pytest.raises(
        IncompatibleResultsError, match=r"line 1: schema must be one of \(1, 2\), got 3"
    ):
        read_rows(tmp_path)


def test_duplicates_that_differ_in_times_only_count_once(tmp_path: Path) -> None:
    write(tmp_path, LINES[0] + LINES[1] + make_row(index=0, seconds=9.0).to_line())
    assert [row.index for row in read_rows(tmp_path)] == [0, 1]


def test_duplicates_that_disagree_are_an_error(tmp_path: Path) -> None:
    write(tmp_path, LINES[0] + LINES[1] + make_row(index=0, success=True).to_line())
    with pytest.raises(ResultsError, match=r"lines 1 and 3: two different rows.*index=0"):
        read_rows(tmp_path)


def test_error_gives_way_to_what_came_of_another_try(tmp_path: Path) -> None:
    failed = make_row(status="error", message="out of memory")
    write(tmp_path, failed.to_line() + make_row(index=1).to_line() + make_row(steps=7).to_line())
    describe(PLAN).write(tmp_path)
    assert [(row.index, row.steps, row.status) for row in read_rows(tmp_path)] == [
        (0, 7, "ok"),
        (1, 10, "ok"),
    ]
    write(tmp_path, make_row(steps=7).to_line() + failed.to_line())
    with pytest.raises(ResultsError, match="lines 1 and 2: two different rows"):
        read_rows(tmp_path)


@pytest.mark.parametrize(
    "line",
    [
        "[" * 100_000,
        LINES[0].replace("-10.0", "9" * 400),
        LINES[0].replace('"index": 0', '"index": -1'),
        LINES[0].replace('"steps": 10', '"steps": -10'),
        LINES[0].replace('"seconds": 1.0', '"seconds": -1.0'),
    ],
)
def test_line_that_no_row_has_is_a_typed_error(tmp_path: Path, line: str) -> None:
    write(tmp_path, f"{line.strip()}\n{LINES[1]}")
    with pytest.raises(ResultsError, match="line 1"):
        read_rows(tmp_path)


def test_second_writer_is_refused_while_the_first_writes(tmp_path: Path) -> None:
    with (
        open_results(tmp_path, PLAN, resume=False),
        pytest.raises(ResultsError, match="in use by another run"),
        open_results(tmp_path, PLAN, resume=True),
    ):
        pass
    with open_results(tmp_path, PLAN, resume=True) as folder:
        assert folder.rows == []


def test_results_are_never_overwritten_without_resume(tmp_path: Path) -> None:
    with open_results(tmp_path, PLAN, resume=False) as folder:
        folder.append(make_row())
    with (
        pytest.raises(ResultsError, match="--resume"),
        open_results(tmp_path, PLAN, resume=False),
    ):
        pass
    assert read_rows(tmp_path) == [make_row()]


def test_unusable_folder_is_explained(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    for out in (file, file / "below"):
        with (
            pytest.raises(ResultsError, match="choose another --out"),
            open_results(out, PLAN, resume=False),
        ):
            pass


def test_new_folders_differ(tmp_path: Path) -> None:
    assert len({new_folder(tmp_path / "runs") for _ in range(3)}) == 3


def test_manifest_survives_the_file_and_names_versions(tmp_path: Path) -> None:
    written = describe(PLAN)
    written.write(tmp_path)
    assert read_manifest(tmp_path) == written
    assert written.plan == PLAN
    assert set(written.packages) >= {"numpy", "mujoco", "dm-control", "gymnasium", "scipy"}
    assert written.code.startswith("sha256:")
    assert written.cpu_count >= 1


def test_resume_may_extend_the_plan(tmp_path: Path) -> None:
    with open_results(tmp_path, PLAN, resume=False):
        created = read_manifest(tmp_path).created
    larger = Plan(agents=("b", "a"), tasks=(TaskSpec("E-v0"), TaskSpec("F-v0")), episodes=4)
    with open_results(tmp_path, larger, resume=True):
        assert read_manifest(tmp_path).plan == larger
        assert read_manifest(tmp_path).created == created


@pytest.mark.parametrize(
    "plan",
    [
        Plan(("a",), (TaskSpec("E-v0"),), 3, seed=1),
        Plan(("a",), (TaskSpec("E-v0"),), 2),
        Plan(("b",), (TaskSpec("E-v0"),), 3),
        Plan(("a",), (TaskSpec("F-v0"),), 3),
    ],
)
def test_resume_refuses_another_plan(tmp_path: Path, plan: Plan) -> None:
    with open_results(tmp_path, PLAN, resume=False):
        pass
    before = (tmp_path / manifests.FILE_NAME).read_bytes()
    with (
        pytest.raises(IncompatibleResultsError, match="cannot resume"),
        open_results(tmp_path, plan, resume=True),
    ):
        pass
    assert (tmp_path / manifests.FILE_NAME).read_bytes() == before


def test_resume_refuses_other_code_and_versions() -> None:
    old = describe(PLAN)
    with pytest.raises(IncompatibleResultsError, match=r"mujoco: '0\.1' there"):
        continued(dataclasses.replace(old, packages={**old.packages, "mujoco": "0.1"}), old)
    with pytest.raises(IncompatibleResultsError, match="code: 'sha256:0' there"):
        continued(dataclasses.replace(old, code="sha256:0"), old)


@pytest.mark.parametrize("content", ["", "{", "[]", '{"schema": 1}'])
def test_broken_manifest_is_explained(tmp_path: Path, content: str) -> None:
    (tmp_path / manifests.FILE_NAME).write_text(content)
    with pytest.raises(ResultsError, match="is not a manifest"):
        read_manifest(tmp_path)


def test_manifest_of_another_schema_is_incompatible(tmp_path: Path) -> None:
    (tmp_path / manifests.FILE_NAME).write_text('{"schema": 99}')
    with pytest.raises(IncompatibleResultsError, match="got 99"):
        read_manifest(tmp_path)


@given(st.binary(max_size=40), st.integers(0, 300), st.integers(0, 300))
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_files_are_rows_or_a_typed_error(
    tmp_path: Path, noise: bytes, cut: int, lost: int
) -> None:
    whole = "".join(LINES).encode()
    damaged = whole[:cut] + noise + whole[cut + lost :]
    (tmp_path / ROWS_NAME).write_bytes(damaged)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResultsWarning)
        try:
            rows = read_rows(tmp_path)
        except ResultsError:
            return
    assert len(rows) <= damaged.count(b"\n") + 1
    assert all(row == row_from_record(json.loads(row.to_line())) for row in rows)


def test_manifest_counts_the_time_of_all_runs(tmp_path: Path) -> None:
    with open_results(tmp_path, PLAN, resume=False):
        assert read_manifest(tmp_path).wall_seconds == 0.0
        time.sleep(0.02)
    first = read_manifest(tmp_path).wall_seconds
    assert 0.02 <= first < 2.0
    with contextlib.suppress(KeyboardInterrupt), open_results(tmp_path, PLAN, resume=True):
        time.sleep(0.02)
        raise KeyboardInterrupt
    assert read_manifest(tmp_path).wall_seconds >= first + 0.02
