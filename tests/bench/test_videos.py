"""Names of video files, and which a report shows."""

from pathlib import Path

import pytest

from benchmarks.rows import Row
from benchmarks.videos import video_path, wanted
from tests.bench.making import make_row


def test_plain_names_make_plain_paths() -> None:
    key = make_row(agent="pc-mppi", env="ICDCableRouting-v0", index=7).key
    assert video_path(Path("out"), key).as_posix() == (
        "out/videos/pc-mppi/ICDCableRouting-v0/default/00007-0.mp4"
    )


@pytest.mark.parametrize("agent", ["../../etc/passwd", "a/b", "..", "", "x" * 500, "ü:é", "<b>"])
def test_no_name_leaves_the_folder(agent: str) -> None:
    path = video_path(Path("out"), make_row(agent=agent).key)
    assert path.parts[:2] == ("out", "videos")
    assert ".." not in path.parts
    assert len(path.parts) == 6
    assert all(len(part.encode()) < 255 for part in path.parts)


def test_different_episodes_have_different_files() -> None:
    keys = [
        make_row(agent=agent, index=index, repeat=repeat, condition=condition).key
        for agent in ("a:b", "a-b", "a/b")
        for index in (0, 1)
        for repeat in (0, 1)
        for condition in ("default", "1 fixture")
    ]
    assert len({video_path(Path(), key) for key in keys}) == len(keys)


def test_first_failures_and_all() -> None:
    def rows(agent: str, *successes: bool) -> list[Row]:
        return [
            make_row(agent=agent, index=i, success=success) for i, success in enumerate(successes)
        ]

    mixed = [*reversed(rows("a", True, False, True)), *rows("b", False, True)]
    assert [(row.agent, row.index) for row in wanted(mixed, "first")] == [("a", 0), ("b", 0)]
    assert [(row.agent, row.index) for row in wanted(mixed, "failures")] == [("a", 1), ("b", 0)]
    assert wanted(mixed, "all") == mixed
    assert wanted([], "first") == []
