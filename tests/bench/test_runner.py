"""Runs of several episodes; what workers do to them is told in tests/faults."""

from pathlib import Path

from benchmarks.manifest import read_manifest
from benchmarks.results import ROWS_NAME, read_rows
from tests.bench import toy
from tests.bench.making import run_toys


def test_rows_do_not_depend_on_the_other_agents(tmp_path: Path) -> None:
    alone = run_toys(tmp_path / "1", toy.Drunk)
    crowd = run_toys(tmp_path / "2", toy.Vandal, toy.Raiser, toy.Nan, toy.Drunk)
    assert [row for row in crowd if row.agent == toy.spec(toy.Drunk)] == alone


def test_all_agents_meet_the_same_scenes(tmp_path: Path) -> None:
    rows = run_toys(tmp_path, toy.Straight, toy.Raiser)
    seeds = {agent: [r.seed for r in rows if r.agent == agent] for agent in {r.agent for r in rows}}
    straight, raiser = seeds.values()
    assert straight == raiser
    assert len(set(straight)) == 4


def test_resume_adds_only_what_is_missing(tmp_path: Path) -> None:
    whole = run_toys(tmp_path / "whole", toy.Drunk, toy.Raiser, n=5)
    run_toys(tmp_path / "parts", toy.Drunk, n=2)
    before = (tmp_path / "parts" / ROWS_NAME).read_bytes()
    assert run_toys(tmp_path / "parts", toy.Drunk, toy.Raiser, n=5, resume=True) == whole
    after = (tmp_path / "parts" / ROWS_NAME).read_bytes()
    assert after.startswith(before)
    assert after.count(b"\n") == 10
    run_toys(tmp_path / "parts", toy.Drunk, toy.Raiser, n=5, resume=True)
    assert (tmp_path / "parts" / ROWS_NAME).read_bytes() == after


def test_errors_are_run_again_only_if_told_and_that_is_told(tmp_path: Path) -> None:
    first = run_toys(tmp_path, toy.Raiser, n=6)
    errors = [row.key for row in first if row.status == "error"]
    assert 0 < len(errors) < 6
    assert run_toys(tmp_path, toy.Raiser, n=6, resume=True) == first
    assert read_manifest(tmp_path).mixed == ()
    again = run_toys(tmp_path, toy.Raiser, n=6, resume=True, retry_errors=True)
    assert again == first  # it raises again
    assert read_rows(tmp_path)
    (note,) = read_manifest(tmp_path).mixed
    assert note.startswith(f"{len(errors)} with an error run again")
    assert (tmp_path / ROWS_NAME).read_bytes().count(b"\n") == 6 + len(errors)


def test_rows_are_on_disk_before_the_next_episode(tmp_path: Path) -> None:
    seen = []

    class Watch:
        def __init__(self, total: int, finished: object) -> None:
            seen.append(total)

        def __enter__(self) -> object:
            return lambda row: seen.append(len(read_rows(tmp_path)))

        def __exit__(self, *error: object) -> None:
            seen.append("end")

    run_toys(tmp_path, toy.Straight, n=3, watch=Watch)
    assert seen == [3, 1, 2, 3, "end"]
