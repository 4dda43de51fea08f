"""How episodes ended."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from benchmarks.rows import Row


def ending(row: Row) -> str:
    """A few words: "success", or why there was none; alike errors get the same words."""
    if row.status == "error":
        return f"error: {_kind(row.message)}"
    if row.success:
        return "success"
    if row.diverged:
        return "the physics diverged"
    return f"out of steps, {100 * row.complete:.0f} % complete"


def count_endings(rows: Sequence[Row]) -> list[tuple[str, int]]:
    """How often each ending was met, success first, then by frequency."""
    counts = Counter(map(ending, rows))
    return sorted(counts.items(), key=lambda item: (item[0] != "success", -item[1], item[0]))


def _kind(message: str) -> str:
    """A message without what differs from episode to episode: numbers and long tails."""
    found = re.search(r"\b[A-Za-z]+(Error|Exception|Exit|Warning|Interrupt)\b", message)
    if found:
        return found.group(0)
    return re.sub(r"\d+", "#", message)[:60] or "no reason given"
