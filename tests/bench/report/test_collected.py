"""Folders joined, and what is said of mixed, unfinished or incompatible ones."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.conditions import Condition, TaskSpec
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.manifest import read_manifest
from benchmarks.plan import Plan
from benchmarks.report.collected import collect
from benchmarks.report.summaries import summaries
from benchmarks.results import open_results
from tests.bench.making import make_row, make_rows, save


def change_manifest(folder: Path, **fields: object) -> Path:
    replace(read_manifest(folder), **fields).write(folder)
    return folder


def test_order_is_that_of_the_manifest_and_missing_agents_are_shown(tmp_path: Path) -> None:
    with open_results(tmp_path, Plan(("z", "b"), (TaskSpec("E-v0"),), 1), resume=False) as results:
        results.append(make_row(agent="z"))
    found = summaries(collect([tmp_path]))
    assert [(s.agent, s.episodes) for s in found] == [("z", 1), ("b", 0)]


def test_folders_are_joined_by_episode_not_by_number(tmp_path: Path) -> None:
    first = save(tmp_path / "1", [make_row(seed=1), make_row(index=1, seed=2)])
    other_seed = save(tmp_path / "2", [make_row(seed=3, success=True)], seed=9)
    same = save(tmp_path / "3", [make_row(seed=1, seconds=5.0)])
    (summary,) = summaries(collect([first, other_seed, same]))
    assert (summary.episodes, summary.successes) == (3, 1)


def test_conditions_and_repeats_are_episodes_of_their_own(tmp_path: Path) -> None:
    rows = [
        make_row(),
        make_row(repeat=1, success=True),
        make_row(condition="noisy"),
    ]
    default, noisy = summaries(collect([save(tmp_path, rows, repeats=2)]))
    assert (default.condition, default.episodes, default.repeats) == ("default", 2, 2)
    assert (noisy.condition, noisy.episodes, noisy.repeats) == ("noisy", 1, 1)


def test_folders_that_disagree_are_refused(tmp_path: Path) -> None:
    first = save(tmp_path / "1", [make_row(seed=1)])
    second = save(tmp_path / "2", [make_row(seed=1, success=True)])
    with pytest.raises(ResultsError, match=r"disagree about agent='a' env='E-v0' .* seed=1"):
        collect([first, second])


def test_one_name_for_two_conditions_is_refused(tmp_path: Path) -> None:
    for folder, noise in (("1", 0.1), ("2", 0.2)):
        task = TaskSpec("E-v0", Condition("noisy", action_noise=noise))
        with open_results(tmp_path / folder, Plan(("a",), (task,), 1), resume=False):
            pass
    with pytest.raises(IncompatibleResultsError, match="'noisy' of 'E-v0' means"):
        collect([tmp_path / "1", tmp_path / "2"])


def test_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match=r"manifest\.json is missing"):
        collect([tmp_path])


def test_clean_and_whole_results_have_no_warning(tmp_path: Path) -> None:
    one = save(tmp_path / "1", make_rows("a", [True, False]))
    two = save(tmp_path / "2", make_rows("b", [True, False]))
    assert collect([one]).warnings() == []
    assert collect([one, two]).warnings() == []


@pytest.mark.parametrize(
    ("fields", "warning"),
    [
        ({"mixed": ("numpy: '1' there, '2' now",)}, "its runs differ: numpy: '1' there, '2' now"),
        ({"dirty": True}, "not committed"),
        ({"code": "sha256:0"}, "different code"),
        ({"settings": {"act_seconds": 1.0}}, "different settings: act_seconds"),
        ({"packages": {"numpy": "0.1"}}, "different packages: numpy"),
        ({"weights": {"a.safetensors": "0"}}, "different weights: a.safetensors"),
        ({"episodes": 9}, "unfinished: 7 of 11 planned episodes are missing"),
    ],
)
def test_what_is_not_clean_is_said(tmp_path: Path, fields: dict[str, object], warning: str) -> None:
    one = save(tmp_path / "1", make_rows("a", [True, False]))
    change_manifest(one, settings={"act_seconds": 60.0}, weights={"a.safetensors": "1"})
    two = change_manifest(save(tmp_path / "2", make_rows("b", [True, False])), **fields)
    (said,) = collect([one, two]).warnings()
    assert warning in said


def test_what_one_folder_alone_tells_is_no_difference(tmp_path: Path) -> None:
    one = save(tmp_path / "1", make_rows("a", [True, False]))
    two = save(tmp_path / "2", make_rows("b", [True, False]))
    change_manifest(one, settings={"act_seconds": 60.0, "agent a": "a.py sha256:1"})
    change_manifest(two, settings={"act_seconds": 60.0, "agent b": "b.py sha256:2"})
    assert collect([one, two]).warnings() == []


def test_result_counts_and_not_the_error_in_another_folder(tmp_path: Path) -> None:
    rows = make_rows("a", [True, False])
    broken = replace(rows[0], status="error", success=False, message="boom")
    one, two = save(tmp_path / "1", [broken, rows[1]]), save(tmp_path / "2", rows)
    for folders in ([one, two], [two, one]):
        found = collect(folders)
        assert [row.status for row in found.rows] == ["ok", "ok"]
        assert found.warnings() == [
            "1 episode with an error in one folder count as they ended in another"
        ]


def test_errors_of_one_episode_need_not_agree(tmp_path: Path) -> None:
    row = make_rows("a", [False])[0]
    broken = [replace(row, status="error", message="late", steps=steps) for steps in (12, 15)]
    folders = [save(tmp_path / str(one.steps), [one]) for one in broken]
    assert [found.status for found in collect(folders).rows] == ["error"]


def test_errors_are_counted(tmp_path: Path) -> None:
    broken = replace(make_rows("a", [False])[0], status="error", message="boom")
    folder = save(tmp_path, [broken, *make_rows("b", [True])])
    assert collect([folder]).warnings() == ["1 episode with an error, which no rate counts"]
