"""The report as one HTML page that needs nothing but itself."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.conditions import DEFAULT, TaskSpec, task_title
from benchmarks.report.chart import Chart, make_chart
from benchmarks.report.collected import Collected, Found, counted
from benchmarks.report.comparisons import Comparison, compare_all, compare_with
from benchmarks.report.episodes_table import as_columns
from benchmarks.report.failures import count_endings, ending
from benchmarks.report.paper import PaperResult, method_of, paper_of, paper_protocol
from benchmarks.report.summaries import Summary, summarise
from benchmarks.rows import Row
from benchmarks.statistics import Interval
from benchmarks.videos import Choice, video_path, wanted

MEGABYTE: Final = 1_000_000
_TEMPLATES: Final = Path(__file__).with_name("templates")


@dataclass(frozen=True)
class Section:
    """What the page says of one task.

    Attributes:
        task: environment and condition.
        title: its name.
        summaries: one for each agent.
        paper: the paper's results by agent.
        chart: success over time, None without a finished episode.
        comparisons: all pairs of agents.
        endings: how episodes ended, by agent.
    """

    task: TaskSpec
    title: str
    summaries: list[Summary]
    paper: dict[str, PaperResult]
    chart: Chart | None
    comparisons: list[Comparison]
    endings: dict[str, list[tuple[str, int]]]

    @property
    def by_agent(self) -> dict[str, Summary]:
        """The summaries by agent."""
        return {summary.agent: summary for summary in self.summaries}

    @property
    def not_run(self) -> list[PaperResult]:
        """Methods of the paper that are not among the agents."""
        run = set(map(method_of, self.by_agent))
        return [result for agent, result in self.paper.items() if agent not in run]


@dataclass(frozen=True)
class Price:
    """What conditions cost an agent in one environment.

    Attributes:
        env: id of the environment.
        agent: name of the agent.
        comparisons: each condition against the default, in the same episodes.
    """

    env: str
    agent: str
    comparisons: list[Comparison]


@dataclass(frozen=True)
class Video:
    """A film on the page.

    Attributes:
        row: of which episode.
        ending: how it ended.
        first: whether it is the first of its agent and task.
        data: base64 of the mp4 file.
    """

    row: Row
    ending: str
    first: bool
    data: str


def render(collected: Collected, *, videos: Choice = "all", megabytes: float = 25.0) -> str:
    """Make the page.

    Args:
        collected: what it is about.
        videos: which videos to embed, of those that there are.
        megabytes: of video files to embed at most; first episodes come before failures, and
            these before all others.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(percent=percent, interval=interval, p_value=p_value, counted=counted)
    environment.globals.update(task_title=task_title, method_of=method_of)
    films, left_out = _embed(collected.found, videos, megabytes)
    sections = [_section(collected, task) for task in collected.tasks]
    agents = list(dict.fromkeys(s.agent for section in sections for s in section.summaries))
    return environment.get_template("page.html").render(
        warnings=collected.warnings(),
        folders=list(zip(collected.folders, collected.manifests, strict=True)),
        sections=sections,
        colours={agent: number for number, agent in enumerate(agents)},
        prices=_prices(collected),
        conditions=[task for task in collected.tasks if task.condition != DEFAULT],
        episodes=as_columns(collected.rows, [film.row for film in films]),
        count=len(collected.found),
        repeated=any(found.row.repeat for found in collected.found),
        protocol=paper_protocol(),
        videos=films,
        videos_left_out=left_out,
    )


def percent(rate: float | None) -> str:
    """A rate for people."""
    return "n/a" if rate is None else f"{100 * rate:.1f} %"


def interval(bounds: Interval | None, scale: float = 100.0, digits: int = 0) -> str:
    """Bounds for people, e.g. "12 to 34"."""
    if bounds is None:
        return "n/a"
    return f"{scale * bounds.low:.{digits}f} to {scale * bounds.high:.{digits}f}"


def p_value(p: float) -> str:
    """A p-value for people."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def _section(collected: Collected, task: TaskSpec) -> Section:
    rows = collected.rows_of(task)
    return Section(
        task=task,
        title=task_title(*task.key),
        summaries=[summarise(agent, *task.key, found) for agent, found in rows.items()],
        paper=paper_of(*task.key),
        chart=make_chart(rows),
        comparisons=compare_all(rows),
        endings={agent: count_endings(found) for agent, found in rows.items()},
    )


def _prices(collected: Collected) -> list[Price]:
    """For every agent and environment that was run as it is and under conditions."""
    rows: dict[tuple[str, str], dict[str, list[Row]]] = {}
    for task in collected.tasks:
        for agent, found in collected.rows_of(task).items():
            rows.setdefault((task.env, agent), {})[task.condition.name] = found
    return [
        Price(env, agent, compare_with(DEFAULT.name, by_condition))
        for (env, agent), by_condition in rows.items()
        if DEFAULT.name in by_condition and len(by_condition) > 1
    ]


def _embed(found: Sequence[Found], choice: Choice, megabytes: float) -> tuple[list[Video], int]:
    """Videos in the order of the rows, and how many there was no room for."""
    rows = [one.row for one in found]
    asked, first = set(wanted(rows, choice)), set(wanted(rows, "first"))
    files = {
        one.row: path
        for one in found
        if one.row in asked and (path := video_path(one.folder, one.row.key)).is_file()
    }
    room = megabytes * MEGABYTE
    taken: dict[Row, str] = {}
    for row in sorted(files, key=lambda row: (row not in first, row.success)):
        content = files[row].read_bytes()
        if len(content) <= room:
            room -= len(content)
            taken[row] = base64.b64encode(content).decode("ascii")
    films = [Video(row, ending(row), row in first, taken[row]) for row in rows if row in taken]
    return films, len(files) - len(films)
