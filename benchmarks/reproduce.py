"""What ``icd-bench reproduce`` does: run recorded episodes again, and compare."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.errors import ResultsError
from benchmarks.manifest import Manifest, describe, read_manifest, what_differs
from benchmarks.plan import Plan
from benchmarks.results import read_rows
from benchmarks.rows import Row

Pair = tuple[Row, Row]
"""An episode as it is recorded, and as it ended now."""


def verdict_on(recorded: Row, now: Row) -> str:
    """Whether an episode was reproduced, in words."""
    if now.status == "error":
        return f"ERROR: {now.message}"
    if recorded.outcome == now.outcome:
        return "the same to the bit"
    return "ends alike" if recorded.success == now.success else "ENDS DIFFERENTLY"


class Recorded(NamedTuple):
    """What is to be run again.

    Attributes:
        plan: of its first test cases.
        rows: of all of them.
        changed: what is not as it was: code, versions, processor.
    """

    plan: Plan
    rows: list[Row]
    changed: list[str]

    def pairs(self, now: Sequence[Row]) -> list[Pair]:
        """Recorded rows beside those of now, in the plan's order."""
        here = {row.key: row for row in now}
        before = {row.key: row for row in self.rows}
        keys = [job.key for job in self.plan.jobs()]
        return [(before[key], here[key]) for key in keys if key in before and key in here]


def recorded(folder: Path, episodes: int) -> Recorded:
    """Read what is to be run again.

    Args:
        folder: results.
        episodes: test cases for each agent and task, from the first on.

    Raises:
        ResultsError: no results there.
    """
    manifest, rows = read_manifest(folder), read_rows(folder)
    if not rows:
        raise ResultsError(f"{folder} has no episodes to reproduce")
    cases = min(episodes, manifest.episodes)
    plan = Plan(manifest.agents, manifest.tasks, cases, manifest.seed, manifest.repeats)
    return Recorded(plan, rows, _changed(manifest, describe(plan)))


def record(pairs: Sequence[Pair], changed: Sequence[str]) -> dict[str, Any]:
    """The same for programs."""
    return {
        "episodes": len(pairs),
        "same_to_the_bit": sum(recorded.outcome == now.outcome for recorded, now in pairs),
        "successes_recorded": sum(recorded.success for recorded, _ in pairs),
        "successes_now": sum(now.success for _, now in pairs),
        "errors": sum(now.status == "error" for _, now in pairs),
        "changed": list(changed),
    }


def _changed(before: Manifest, now: Manifest) -> list[str]:
    found = list(what_differs(before, now))
    if before.cpu_model != now.cpu_model:
        found.append(f"processor: {before.cpu_model!r} there, {now.cpu_model!r} now")
    return found
