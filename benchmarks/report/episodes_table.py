"""All episodes as columns of numbers and short lists of names, for the page's table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.conditions import task_title
from benchmarks.report.failures import ending
from benchmarks.rows import Row


def as_columns(rows: Sequence[Row], videos: Sequence[Row]) -> dict[str, Any]:
    """What the page's script reads; names are listed once and referred to by number.

    Args:
        rows: all episodes.
        videos: those of them whose video is on the page, in its order.
    """
    shown = {row: number for number, row in enumerate(videos)}
    return {
        "agent": _coded([row.agent for row in rows]),
        "task": _coded([task_title(row.env, row.condition) for row in rows]),
        "ending": _coded([ending(row) for row in rows]),
        "message": _coded([row.message for row in rows]),
        "index": [row.index for row in rows],
        "repeat": [row.repeat for row in rows],
        "seed": [row.seed for row in rows],
        "complete": [round(100 * row.complete, 1) for row in rows],
        "steps": [row.steps for row in rows],
        "return": [round(row.return_, 2) for row in rows],
        "seconds": [round(row.seconds, 2) for row in rows],
        "act": [round(1e3 * row.act_seconds, 2) for row in rows],
        "video": [shown.get(row, -1) for row in rows],
    }


def _coded(values: Sequence[str]) -> dict[str, Any]:
    numbers = {value: number for number, value in enumerate(dict.fromkeys(values))}
    return {"names": list(numbers), "codes": [numbers[value] for value in values]}
