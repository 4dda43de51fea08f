"""icd-bench reproduce: recorded episodes again."""

import json
import os
import signal
from pathlib import Path
from typing import Any

import pytest

from benchmarks import run_command
from benchmarks.manifest import FILE_NAME as MANIFEST_NAME
from benchmarks.results import ROWS_NAME
from tests.bench import toy
from tests.bench.making import icd_bench


@pytest.fixture
def published(tmp_path: Path) -> Path:
    folder = tmp_path / "published"
    ran = icd_bench(
        "run", "--agent", toy.spec(toy.Planner), "--env", toy.ENV, "--episodes", 3, "--out", folder
    )
    assert ran.exit_code == 0, ran.stderr
    return folder


def change_first_row(folder: Path, **fields: object) -> None:
    path = folder / ROWS_NAME
    first, *others = path.read_text().splitlines()
    lines = [json.dumps({**json.loads(first), **fields}), *others]
    path.write_text("\n".join(lines) + "\n")


def reproduced(folder: Path, *more: object) -> tuple[int, dict[str, Any]]:
    result = icd_bench("reproduce", folder, "--out", folder.with_name("again"), "--json", *more)
    return result.exit_code, json.loads(result.stdout)


def test_episodes_are_the_same_to_the_bit(published: Path) -> None:
    code, found = reproduced(published)
    assert code == 0
    assert found == {
        "episodes": 3,
        "same_to_the_bit": 3,
        "successes_recorded": 3,
        "successes_now": 3,
        "errors": 0,
        "changed": [],
    }


def test_only_the_first_cases_are_run(published: Path) -> None:
    code, found = reproduced(published, "--episodes", 2)
    assert (code, found["episodes"]) == (0, 2)


def test_other_steps_are_not_the_same_but_end_alike(published: Path) -> None:
    change_first_row(published, steps=1)
    code, found = reproduced(published)
    assert code == 0
    assert (found["same_to_the_bit"], found["successes_recorded"]) == (2, 3)


def test_another_ending_fails_and_is_shown(published: Path) -> None:
    change_first_row(published, success=False)
    shown = icd_bench("reproduce", published, "--out", published.with_name("again"))
    assert shown.exit_code == 1
    assert shown.stdout.count("ENDS DIFFERENTLY") == 1
    assert shown.stdout.count("the same to the bit") == 2


def test_what_has_changed_is_said(published: Path) -> None:
    path = published / MANIFEST_NAME
    record = json.loads(path.read_text())
    path.write_text(json.dumps({**record, "cpu_model": "abacus", "code": "sha256:older"}))
    shown = icd_bench("reproduce", published, "--out", published.with_name("again"))
    assert shown.exit_code == 0
    assert "changed since: processor: 'abacus' there" in shown.stdout
    assert "changed since: code: 'sha256:older' there" in shown.stdout


def test_an_agent_that_raises_now_is_an_error(published: Path) -> None:
    for name in (MANIFEST_NAME, ROWS_NAME):
        path = published / name
        path.write_text(path.read_text().replace(toy.spec(toy.Planner), toy.spec(toy.Raiser)))
    shown = icd_bench("reproduce", published, "--out", published.with_name("again"))
    assert shown.exit_code == 1
    assert shown.stdout.count("ERROR: ") == 3


def test_recorded_error_is_not_reproduced_by_a_failure(published: Path) -> None:
    change_first_row(published, status="error", success=False, message="out of memory")
    shown = icd_bench("reproduce", published, "--out", published.with_name("again"))
    assert shown.exit_code == 1
    assert shown.stdout.count("ENDS DIFFERENTLY") == 1


def test_agent_gets_what_it_was_given_and_other_files_of_it_are_told(published: Path) -> None:
    path = published / MANIFEST_NAME
    record = json.loads(path.read_text())
    agent = f"agent {toy.spec(toy.Planner)}"
    settings = {**record["settings"], "act_seconds": 33.0, agent: "tests sha256:older"}
    path.write_text(json.dumps({**record, "settings": settings}))
    _, found = reproduced(published)
    assert [text.partition(" sha")[0] for text in found["changed"]] == [f"{agent}: 'tests"]
    again = json.loads((published.with_name("again") / MANIFEST_NAME).read_text())
    assert again["settings"]["act_seconds"] == 33.0


def test_interrupted_while_agents_are_looked_at_it_says_so_and_makes_no_folder(
    published: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(run_command, "look_first", interrupted)
    stopped = icd_bench("reproduce", published, "--out", published.with_name("again"))
    signal.signal(signal.SIGTERM, before)
    assert (stopped.exit_code, stopped.exception.__class__) == (143, SystemExit)
    assert "interrupted; the same command goes on" in stopped.stderr
    assert not published.with_name("again").exists()


def test_nothing_to_reproduce_is_said_in_one_line(tmp_path: Path) -> None:
    refused = icd_bench("reproduce", tmp_path / "nowhere")
    assert refused.exit_code == 2
    assert "no results in" in refused.stderr
