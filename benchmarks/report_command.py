"""What ``icd-bench report`` does once its arguments are parsed."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from benchmarks.errors import ResultsError
from benchmarks.report.collected import Collected, collect
from benchmarks.report.summaries import summaries
from benchmarks.videos import Choice
from icd_agent.replacing import write_atomically

Form = Literal["table", "json", "markdown", "latex"]


def report(
    folders: Sequence[Path],
    form: Form = "table",
    *,
    html: Path | None = None,
    csv: Path | None = None,
    videos: Choice = "all",
    megabytes: float = 25.0,
) -> int:
    """Print the table and write the files that are asked for.

    Args:
        folders: results.
        form: what to print on stdout.
        html: file for the page.
        csv: file for the rows.
        videos: which videos go into the page.
        megabytes: of videos in the page at most.

    Returns:
        The number of episodes with an error.

    Raises:
        ResultsError: a folder cannot be read, or a file not be written.
    """
    collected = collect(folders)
    found = summaries(collected)
    if html is not None:
        from benchmarks.report.page import render

        _write(html, render(collected, videos=videos, megabytes=megabytes))
    if csv is not None:
        from benchmarks.csv_export import to_csv

        _write(csv, to_csv(collected.rows))
    if form == "json":
        print(json.dumps([summary.record() for summary in found]))
        for warning in collected.warnings():
            print(f"icd-bench: warning: {warning}", file=sys.stderr)
    elif form == "table":
        from benchmarks.tables import print_summaries

        print_summaries(found, collected.warnings())
    else:
        _print_text(collected, form)
    return sum(summary.errors for summary in found)


def _print_text(collected: Collected, form: Form) -> None:
    from benchmarks.report.text import to_latex, to_markdown

    print(to_markdown(collected) if form == "markdown" else to_latex(collected), end="")


def _write(path: Path, text: str) -> None:
    try:
        write_atomically(path, text.encode(errors="backslashreplace"))
    except OSError as error:
        raise ResultsError(
            f"cannot write {path}: {error}: name a file in a folder that exists"
        ) from error
