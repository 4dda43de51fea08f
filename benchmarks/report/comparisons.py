"""Agents against one another on the episodes that both finished."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

from benchmarks.rows import Row
from benchmarks.statistics import Interval, bootstrap_mean, holm, paired_p

LEVEL: Final = 0.05
"""Corrected p-value below which a difference is called one."""


@dataclass(frozen=True)
class Comparison:
    """Two agents on one task.

    Attributes:
        first: an agent.
        second: another.
        common: episodes that both finished; nothing else is compared.
        first_only: of these, successes of the first alone.
        second_only: successes of the second alone.
        success_difference: first minus second, None without a common episode.
        complete_difference: mean difference of complete rates, first minus second.
        complete_ci: 95 % bootstrap interval of that, None with fewer than two cases.
        p: of the exact paired test of success; see ``benchmarks.statistics.paired_p``.
        corrected_p: the same after Holm's correction for all pairs of the task.
    """

    first: str
    second: str
    common: int
    first_only: int
    second_only: int
    success_difference: float | None
    complete_difference: float | None
    complete_ci: Interval | None
    p: float | None
    corrected_p: float | None

    @property
    def verdict(self) -> str:
        """What may be said: "better" only where the corrected test says so."""
        if self.corrected_p is None:
            return "no common episodes"
        shown = "p < 0.001" if self.corrected_p < 0.001 else f"p = {self.corrected_p:.3f}"
        if self.corrected_p >= LEVEL:
            return f"no difference shown ({shown})"
        better = self.first if self.first_only > self.second_only else self.second
        return f"{better} better ({shown})"


def compare_all(rows: Mapping[str, Sequence[Row]]) -> list[Comparison]:
    """Every pair of agents of one task, with p-values that may be read together.

    Args:
        rows: of one task, by agent.
    """
    return _corrected([compare(a, b, rows[a], rows[b]) for a, b in combinations(rows, 2)])


def compare_with(reference: str, rows: Mapping[str, Sequence[Row]]) -> list[Comparison]:
    """Everything against one reference, with p-values that may be read together.

    Args:
        reference: the second of every pair.
        rows: by name, the reference's among them.
    """
    others = [name for name in rows if name != reference]
    return _corrected([compare(a, reference, rows[a], rows[reference]) for a in others])


def _corrected(comparisons: Sequence[Comparison]) -> list[Comparison]:
    tested = [comparison for comparison in comparisons if comparison.p is not None]
    p_values = holm([comparison.p for comparison in tested if comparison.p is not None])
    corrected = dict(zip(map(id, tested), p_values, strict=True))
    return [replace(c, corrected_p=corrected.get(id(c))) for c in comparisons]


def compare(
    first: str, second: str, first_rows: Sequence[Row], second_rows: Sequence[Row]
) -> Comparison:
    """Two agents' rows of one task; ``corrected_p`` is not corrected yet."""
    theirs = {(row.seed, row.repeat): row for row in second_rows if row.status == "ok"}
    pairs = [
        (mine, theirs[mine.seed, mine.repeat])
        for mine in first_rows
        if mine.status == "ok" and (mine.seed, mine.repeat) in theirs
    ]
    cases = [mine.seed for mine, _ in pairs]
    success = [int(mine.success) - int(other.success) for mine, other in pairs]
    complete = [mine.complete - other.complete for mine, other in pairs]
    p = None
    if pairs:
        p = paired_p([a.success for a, _ in pairs], [b.success for _, b in pairs], cases)
    return Comparison(
        first=first,
        second=second,
        common=len(pairs),
        first_only=success.count(1),
        second_only=success.count(-1),
        success_difference=sum(success) / len(pairs) if pairs else None,
        complete_difference=sum(complete) / len(pairs) if pairs else None,
        complete_ci=bootstrap_mean(complete, cases),
        p=p,
        corrected_p=p,
    )
