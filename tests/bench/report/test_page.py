"""The page: self-contained, complete, and nothing in it but text where names are shown."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from benchmarks.report.collected import collect
from benchmarks.report.page import render
from benchmarks.rows import Row
from benchmarks.suites import episode_seed
from benchmarks.videos import video_path
from tests.bench.making import make_row, make_rows, save

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>'\"{{ 7*7 }}"
CABLE = "ICDCableRouting-v0"


class Reader(HTMLParser):
    """Collects what a browser would see."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self._inside = ""
        self.data = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside = str(dict(attrs).get("id", tag))

    def handle_endtag(self, tag: str) -> None:
        if tag in ("script", "style"):
            self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "data":
            self.data += data
        elif not self._inside:
            self.text.append(data)

    def count(self, tag: str) -> int:
        return sum(name == tag for name, _ in self.tags)


def page_of(*folders: Path, **options: object) -> Reader:
    return Reader(render(collect(folders), **options))


def test_hostile_names_and_messages_stay_text(tmp_path: Path) -> None:
    rows = [
        make_row(agent=EVIL, env=EVIL, condition=EVIL, status="error", message=f"{EVIL}Error"),
        make_row(agent="b", env=EVIL, condition=EVIL),
    ]
    honest = page_of(save(tmp_path / "honest", make_rows("a", [True]) + make_rows("b", [True])))
    page = page_of(save(tmp_path / "evil", rows))
    assert page.count("script") == honest.count("script") == 2
    assert page.count("img") == 0
    assert not any(name.startswith("on") for _, attributes in page.tags for name in attributes)
    assert EVIL in page.text
    data = json.loads(page.data)
    assert data["agent"]["names"] == [EVIL, "b"]
    assert f"{EVIL}Error" in data["message"]["names"]
    assert "<" not in page.data


def test_page_needs_nothing_but_itself(tmp_path: Path) -> None:
    page = page_of(save(tmp_path, make_rows("a", [True, False], env=CABLE)))
    for _, attributes in page.tags:
        for name in ("src", "href", "srcset", "action", "poster", "data"):
            assert str(attributes.get(name, "#")).startswith(("#", "data:"))
    whole = render(collect([tmp_path]))
    assert not re.search(r"https?://|@import|url\(", whole)
    assert "default-src 'none'" in whole


def test_tables_hold_our_numbers_beside_the_papers(tmp_path: Path) -> None:
    rows = make_rows("pc-mppi", [True] * 7 + [False] * 13, env=CABLE, privileged="simulator")
    text = " ".join(" ".join(page_of(save(tmp_path, rows)).text).split())
    assert "35.0 % 7/20, 18 to 57" in text
    assert "simulator" in text
    assert "25.0 % 11 to 47" in text  # the paper's
    assert "Global NDF not run" in text
    assert "13 out of steps, 0 % complete" in text


def test_a_method_that_was_run_in_other_settings_was_run(tmp_path: Path) -> None:
    rows = make_rows("global-ndf-paper", [True] * 7 + [False] * 13, env=CABLE)
    text = " ".join(" ".join(page_of(save(tmp_path, rows)).text).split())
    assert "Global NDF not run" not in text
    assert "50.0 % 30 to 70" in text  # the paper's
    assert "PC-MPPI not run" in text


def test_verdicts_and_warnings_are_shown(tmp_path: Path) -> None:
    rows = make_rows("good", [True] * 10) + make_rows("bad", [False] * 10)
    broken = make_row(
        agent="bad", index=10, seed=episode_seed(0, "E-v0", 10), status="error", message="boom"
    )
    text = " ".join(page_of(save(tmp_path, [*rows, broken])).text)
    assert "good better (p = 0.002)" in text
    assert "1 episode with an error" in text
    assert "unfinished: 1 of 22 planned" in text


@pytest.mark.parametrize(
    "rows",
    [
        [],
        [make_row()],
        make_rows("a", [True] * 3) + make_rows("b", [True] * 3),
        make_rows("a", [False] * 3) + make_rows("b", [False]),
        [make_row(status="error", message="boom")] * 1,
        [make_row(agent=str(i), index=i, seed=i) for i in range(12)],
    ],
)
def test_extremes_have_a_page(tmp_path: Path, rows: list[Row]) -> None:
    page = page_of(save(tmp_path, rows))
    assert len(json.loads(page.data)["seed"]) == len(rows)


def test_every_episode_is_in_the_data(tmp_path: Path) -> None:
    rows = make_rows("a", [True, False, True]) + make_rows("b", [False] * 3, condition="noisy")
    data = json.loads(page_of(save(tmp_path, rows)).data)
    assert [data["agent"]["names"][code] for code in data["agent"]["codes"]] == [*"aaabbb"]
    assert data["task"]["names"] == ["E-v0", "E-v0, noisy"]
    assert data["seed"] == [row.seed for row in rows]
    assert data["steps"] == [row.steps for row in rows]
    assert data["video"] == [-1] * 6


def film(folder: Path, row: Row, content: bytes) -> None:
    path = video_path(folder, row.key)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def films(page: Reader) -> list[str]:
    return [str(attributes["data-film"]) for tag, attributes in page.tags if tag == "video"]


def test_videos_are_embedded_by_choice_and_need(tmp_path: Path) -> None:
    rows = make_rows("a", [True, True, False, True])
    folder = save(tmp_path, rows)
    for row in rows[:3]:
        film(folder, row, bytes([row.index]) * 300)
    zero, one, two = (["AAAA", "AQEB", "AgIC"][i] * 100 for i in range(3))
    assert films(page_of(folder)) == [zero, one, two]
    assert films(page_of(folder, videos="first")) == [zero]
    assert films(page_of(folder, videos="failures")) == [two]
    small = page_of(folder, megabytes=0.0007)
    assert films(small) == [zero, two]
    assert "1 more did not fit" in " ".join(small.text)
    assert json.loads(small.data)["video"] == [0, -1, 1, -1]
    assert films(page_of(folder, megabytes=0.0)) == []


def test_page_is_the_same_every_time(tmp_path: Path) -> None:
    folder = save(tmp_path, make_rows("a", [True, False] * 5) + make_rows("b", [True] * 10))
    assert render(collect([folder])) == render(collect([folder]))


def test_conditions_are_compared_with_the_default(tmp_path: Path) -> None:
    rows = make_rows("a", [True] * 8) + make_rows("a", [False] * 8, condition="noisy")
    text = " ".join(" ".join(page_of(save(tmp_path / "1", rows)).text).split())
    assert "What conditions cost" in text
    assert "noisy 8 0 8 -100.0 -100.0 0.008 default better (p = 0.008)" in text
    alone = page_of(save(tmp_path / "2", make_rows("a", [True], condition="noisy")))
    assert "What conditions cost" not in " ".join(alone.text)
