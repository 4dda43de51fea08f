"""Renderers that hang or crash cost the video, never the episode."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from benchmarks.errors import ResultsWarning
from benchmarks.executors import Local
from tests.bench import toy
from tests.bench.making import LIMITS, run_toys

QUICK = dataclasses.replace(LIMITS, render_seconds=0.5)


@pytest.mark.parametrize(
    ("env", "reason"),
    [
        (toy.HANGING_PICTURES, "rendering, step 0: over its time budget of 0.5 s"),
        (toy.CRASHING_PICTURES, r"rendering, step 0: worker died \(signal 11\)"),
    ],
)
def test_episode_is_repeated_once_without_video(env: str, reason: str, tmp_path: Path) -> None:
    plain = run_toys(tmp_path / "plain", toy.Drunk, n=2, env=env)
    with pytest.warns(ResultsWarning, match=reason):
        filmed = run_toys(
            tmp_path / "filmed", toy.Drunk, n=2, env=env,
            executor=Local(1), limits=QUICK, videos="all",
        )  # fmt: skip
    assert filmed == plain
    assert [row.status for row in filmed] == ["ok", "ok"]
    assert not list((tmp_path / "filmed").rglob("*.mp4"))
