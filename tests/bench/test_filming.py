"""Videos of toy episodes."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.rows import Row
from benchmarks.videos import FOLDER_NAME, video_path
from tests.bench import toy
from tests.bench.making import run_toys

N = 6


def videos(out: Path) -> set[Path]:
    return {path for path in (out / FOLDER_NAME).rglob("*") if path.is_file()}


def of(rows: list[Row], out: Path) -> set[Path]:
    return {video_path(out, row.key) for row in rows}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    return run_toys(tmp_path_factory.mktemp("plain"), toy.Drunk, toy.Raiser, n=N)


def test_filmed_episodes_are_those_that_were_not_filmed(plain: list[Row], tmp_path: Path) -> None:
    import imageio.v3 as iio

    rows = run_toys(tmp_path, toy.Drunk, toy.Raiser, n=N, videos="all")
    assert rows == plain
    assert videos(tmp_path) == of(rows, tmp_path)
    for row in rows:
        frames = iio.imread(video_path(tmp_path, row.key))
        assert frames.shape == (row.steps + 1, 32, 48, 3)
        assert frames.max() > 100 or row.steps < 2
    assert max(row.steps for row in rows) > 1


def test_first_or_failures_only(plain: list[Row], tmp_path: Path) -> None:
    rows = run_toys(tmp_path / "first", toy.Drunk, toy.Raiser, n=N, videos="first")
    first = [row for row in rows if row.index == 0]
    assert (videos(tmp_path / "first"), len(first)) == (of(first, tmp_path / "first"), 2)
    rows = run_toys(tmp_path / "failures", toy.Drunk, toy.Raiser, n=N, videos="failures")
    failed = [row for row in rows if not row.success]
    assert videos(tmp_path / "failures") == of(failed, tmp_path / "failures")
    assert 0 < len(failed) < len(rows)
    assert rows == plain


def test_without_opengl_there_is_a_warning_and_no_video(tmp_path: Path) -> None:
    seeing = run_toys(tmp_path / "seeing", toy.Drunk, n=2, env=toy.BLIND)
    with pytest.warns(UserWarning, match="no videos: OpenGL did not start"):
        blind = run_toys(tmp_path / "blind", toy.Drunk, n=2, env=toy.BLIND, videos="all")
    assert blind == seeing
    assert [row.status for row in blind] == ["ok", "ok"]
    assert videos(tmp_path / "blind") == set()


@pytest.mark.filterwarnings("ignore:.*render_modes")
def test_environment_without_pictures_is_played_without(tmp_path: Path) -> None:
    plain = run_toys(tmp_path / "plain", toy.Drunk, n=2, env=toy.PICTURELESS)
    with pytest.warns(UserWarning, match="no videos of .*render_mode"):
        rows = run_toys(tmp_path / "out", toy.Drunk, n=2, env=toy.PICTURELESS, videos="first")
    assert rows == plain
    assert [row.status for row in rows] == ["ok", "ok"]
