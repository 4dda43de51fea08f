"""The same tables for papers and pull requests: Markdown and LaTeX."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from benchmarks.conditions import task_title
from benchmarks.report.collected import Collected
from benchmarks.report.comparisons import compare_all
from benchmarks.report.paper import PaperResult, method_of, paper_of
from benchmarks.report.summaries import Summary, summaries, summarise
from benchmarks.statistics import Interval

_HEADINGS: Final = (
    "agent", "given", "success", "complete rate", "steps", "ms/act", "errors", "paper",
)  # fmt: skip
_LATEX: Final = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}
NOTE: Final = (
    "95 % Wilson intervals in brackets; steps: mean over successes; errors count in no rate; "
    "paper: success / complete rate in percent, 20 runs."
)


def to_markdown(collected: Collected) -> str:
    """Success at a glance if there are several tasks, then a table and comparisons for each."""
    parts = [f"> **Read with care:** {_plain(warning)}\n" for warning in collected.warnings()]
    found = summaries(collected)
    if len(collected.tasks) > 1:
        parts.append("### Success at a glance\n")
        parts.append("\n".join(map(_markdown_line, _glance(collected, found))) + "\n")
    for task in collected.tasks:
        rows = collected.rows_of(task)
        lines = [_cells(one) for one in found if (one.env, one.condition) == task.key]
        parts.append(f"### {_plain(task_title(*task.key))}\n")
        parts.append("\n".join(_markdown_line(line) for line in (_HEADINGS, _RULE, *lines)) + "\n")
        verdicts = [
            f"- {c.first} / {c.second}, {c.common} common episodes: {c.verdict}"
            for c in compare_all(rows)
        ]
        if verdicts:
            parts.append("\n".join(map(_plain, verdicts)) + "\n")
    return "\n".join([*parts, f"{NOTE}\n"])


def to_latex(collected: Collected) -> str:
    """One ``booktabs`` table for each task."""
    tables = []
    for task in collected.tasks:
        rows = collected.rows_of(task)
        lines = [_cells(summarise(agent, *task.key, found)) for agent, found in rows.items()]
        body = "\n".join(f"    {_latex_line(line)}" for line in lines)
        tables.append(
            "\\begin{table}\n  \\centering\n"
            f"  \\begin{{tabular}}{{ll{'r' * (len(_HEADINGS) - 2)}}}\n    \\toprule\n"
            f"    {_latex_line(_HEADINGS)}\n    \\midrule\n{body}\n    \\bottomrule\n"
            "  \\end{tabular}\n"
            f"  \\caption{{{_escaped(task_title(*task.key))}. {_escaped(NOTE)}}}\n\\end{{table}}\n"
        )
    comments = [f"% {' '.join(warning.split())}\n" for warning in collected.warnings()]
    return "% needs \\usepackage{booktabs}\n" + "".join(comments) + "\n".join(tables)


def _glance(collected: Collected, found: Sequence[Summary]) -> list[tuple[str, ...]]:
    """Heading, rule and a line for each agent; empty where it was not run."""
    titles = [task_title(*task.key) for task in collected.tasks]
    agents: dict[str, dict[str, Summary]] = {}
    for summary in found:
        title = task_title(summary.env, summary.condition)
        agents.setdefault(summary.agent, {})[title] = summary
    lines = [("agent", *titles), ("---", *("---:",) * len(titles))]
    for agent, by_title in agents.items():
        cells = [_success(by_title[title]) if title in by_title else "" for title in titles]
        lines.append((agent, *cells))
    return lines


_RULE: Final = ("---", "---", *("---:",) * (len(_HEADINGS) - 2))


def _cells(summary: Summary) -> tuple[str, ...]:
    steps, seconds = summary.success_steps, summary.act_seconds
    return (
        summary.agent,
        summary.privileged or "observations",
        _success(summary),
        _rate(summary.complete, summary.complete_ci),
        "n/a" if steps is None else f"{steps:.0f}",
        "n/a" if seconds is None else f"{1e3 * seconds:.1f}",
        str(summary.errors),
        _paper(paper_of(summary.env, summary.condition).get(method_of(summary.agent))),
    )


def _success(summary: Summary) -> str:
    rate = _rate(summary.success, summary.success_ci)
    return f"{summary.successes}/{summary.finished} {rate}"


def _rate(rate: float | None, interval: Interval | None) -> str:
    if rate is None or interval is None:
        return "n/a"
    return f"{100 * rate:.1f} [{100 * interval.low:.0f}, {100 * interval.high:.0f}]"


def _paper(result: PaperResult | None) -> str:
    if result is None:
        return ""
    complete = "" if result.complete is None else f" / {100 * result.complete:g}"
    return f"{100 * result.success:g}{complete}"


def _markdown_line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(_plain, cells))} |"


def _plain(text: str) -> str:
    """Text that Markdown and the HTML made of it show as it is."""
    return re.sub(r"([\\`*_<>\[\]|~&])", r"\\\1", " ".join(text.split()))


def _latex_line(cells: Sequence[str]) -> str:
    return f"{' & '.join(map(_escaped, cells))} \\\\"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(character, character) for character in " ".join(text.split()))
