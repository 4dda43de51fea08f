"""Folders of demonstrations: the same bytes whatever happens on the way."""

import os
import signal
from pathlib import Path

import pytest

from benchmarks import collect as collecting
from benchmarks.collect import collect
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.executors import InProcess, Local
from benchmarks.manifest import read_manifest
from benchmarks.results import ROWS_NAME
from icd_envs.demonstrations.header import FILE_NAME, shard_path
from icd_envs.demonstrations.shard import Recording, encode
from icd_envs.errors import DemonstrationsError
from tests.demonstrations.making import contents, make_header, make_recording

HEADER = make_header(episodes=5)
HERE = InProcess()


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """No physics; the seeds that were recorded."""
    seeds: list[int] = []

    def record(task: object, *, seed: int, steps: int, split: str, noisy: bool) -> Recording:
        seeds.append(seed)
        return make_recording(steps, seed)

    monkeypatch.setattr(collecting, "record", record)
    return seeds


def test_number_of_workers_does_not_matter(tmp_path: Path) -> None:
    rows = [
        collect(HEADER, tmp_path / name, executor, resume=False)
        for name, executor in {"1": InProcess(), "2": Local(2)}.items()
    ]
    assert rows[0] == rows[1]
    assert [row.index for row in rows[0]] == list(range(5))
    assert {row.steps for row in rows[0]} == {HEADER.steps}
    assert contents(tmp_path / "1") == contents(tmp_path / "2")
    assert len(contents(tmp_path / "1")) == 4


def test_finished_shards_are_not_recorded_again(tmp_path: Path, quick: list[int]) -> None:
    rows = collect(HEADER, tmp_path, HERE)
    assert len(quick) == 5
    whole = contents(tmp_path)
    shard_path(tmp_path, 1).unlink()
    assert collect(HEADER, tmp_path, HERE) == rows
    assert quick[5:] == quick[2:4]
    assert contents(tmp_path) == whole


def test_more_episodes_later_give_the_folder_of_all_at_once(
    tmp_path: Path, quick: list[int]
) -> None:
    for episodes in (3, 5):
        collect(make_header(episodes=episodes), tmp_path / "grown", HERE)
    collect(HEADER, tmp_path / "whole", HERE)
    assert contents(tmp_path / "grown") == contents(tmp_path / "whole")


def test_watch_sees_every_new_row_and_knows_the_old(tmp_path: Path, quick: list[int]) -> None:
    class Watch:
        def __init__(self, total: int, finished: tuple[object, ...]) -> None:
            self.seen = [total, len(finished)]
            watches.append(self)

        def __enter__(self) -> object:
            return lambda row: self.seen.append(row.index)

        def __exit__(self, *error: object) -> None:
            self.seen.append(-1)

    watches: list[Watch] = []
    collect(HEADER, tmp_path, HERE, watch=Watch)
    shard_path(tmp_path, 2).unlink()
    collect(HEADER, tmp_path, HERE, watch=Watch)
    assert [watch.seen for watch in watches] == [[5, 0, 0, 1, 2, 3, 4, -1], [5, 4, 4, -1]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"steps": 7}, "steps: 6 there, 7 now"),
        ({"noisy": False}, "noisy: True there"),
        ({"seed": 6}, "seed: 5 there"),
        ({"shard_episodes": 3}, "shard_episodes: 2 there"),
        ({"episodes": 4}, "episodes=5 there is not"),
    ],
)
def test_another_header_is_refused_and_nothing_changes(
    tmp_path: Path, quick: list[int], change: dict[str, object], message: str
) -> None:
    collect(HEADER, tmp_path, HERE)
    before = contents(tmp_path)
    with pytest.raises(IncompatibleResultsError, match=message):
        collect(make_header(**{"episodes": 5, **change}), tmp_path, HERE)
    assert contents(tmp_path) == before


def test_another_code_is_refused(
    tmp_path: Path, quick: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    collect(HEADER, tmp_path, HERE)
    assert read_manifest(tmp_path).agents == ("expert-noisy",)
    monkeypatch.setattr("benchmarks.provenance.code_fingerprint", lambda: "sha256:other")
    with pytest.raises(IncompatibleResultsError, match="code: "):
        collect(HEADER, tmp_path, HERE)


def test_existing_folder_is_kept_without_resume(tmp_path: Path, quick: list[int]) -> None:
    collect(HEADER, tmp_path, HERE)
    with pytest.raises(ResultsError, match="has demonstrations already"):
        collect(HEADER, tmp_path, HERE, resume=False)


def test_results_of_a_run_are_no_place_for_demonstrations(tmp_path: Path) -> None:
    (tmp_path / ROWS_NAME).write_text("")
    with pytest.raises(ResultsError, match="choose another --out"):
        collect(HEADER, tmp_path, HERE)


def test_damaged_or_foreign_shard_is_named(tmp_path: Path, quick: list[int]) -> None:
    collect(HEADER, tmp_path, HERE)
    sound = shard_path(tmp_path, 1).read_bytes()
    shard_path(tmp_path, 1).write_bytes(sound[:-40])
    with pytest.raises(DemonstrationsError, match=r"shard-00001\.npz is damaged"):
        collect(HEADER, tmp_path, HERE)
    shard_path(tmp_path, 1).write_bytes(encode([make_recording(seed=1)]))
    with pytest.raises(DemonstrationsError, match=r"shard-00001\.npz has other episodes"):
        collect(HEADER, tmp_path, HERE)


def test_full_disk_keeps_what_is_finished(
    tmp_path: Path, quick: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    fsync = os.fsync
    calls: list[int] = []

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == 4:  # manifest, header, shard 0, shard 1
            raise OSError(28, "No space left on device")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ResultsError, match=r"shard-00001.*No space left.*same command again"):
        collect(HEADER, tmp_path, HERE)
    assert set(contents(tmp_path)) == {FILE_NAME, "shard-00000.npz"}
    assert not list(tmp_path.glob("*.tmp"))
    collect(HEADER, tmp_path, HERE)
    assert len(contents(tmp_path)) == 4


class KillsItsWorker:
    """Stands in for the recording of an episode."""

    def __call__(self, *arguments: object, **more: object) -> None:
        os.kill(os.getpid(), signal.SIGKILL)


def test_episode_that_kills_its_worker_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(collecting, "_record", KillsItsWorker())
    with pytest.raises(ResultsError, match=r"twice in shard \d.*\(signal 9\).*seeds \d+, \d+"):
        collect(HEADER, tmp_path, Local(2))
