"""From rows to rates: what is known about each agent on each task."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.report.collected import Collected
from benchmarks.rows import Row
from benchmarks.statistics import Interval, bootstrap_mean, wilson


@dataclass(frozen=True)
class Summary:
    """One line of the table.

    Attributes:
        agent: name of the agent.
        env: id of the environment.
        condition: what it was put under.
        episodes: rows, errors included.
        errors: rows of status "error"; no rate or mean counts them.
        successes: episodes that ended in success.
        success: their rate, None without a finished episode.
        success_ci: 95 % Wilson interval of it.
        complete: mean complete rate, None without a finished episode.
        complete_ci: 95 % Wilson interval of it, conservative.
        complete_bootstrap: 95 % bootstrap interval of it, None with fewer than two cases.
        success_steps: mean control steps of the successes.
        success_steps_ci: 95 % bootstrap interval of it.
        act_seconds: [s] mean wall time of one ``act``.
        repeats: most episodes on one test case.
        privileged: what the agent was given beyond observations, see ``Row``.
    """

    agent: str
    env: str
    condition: str
    episodes: int
    errors: int
    successes: int
    success: float | None
    success_ci: Interval | None
    complete: float | None
    complete_ci: Interval | None
    complete_bootstrap: Interval | None
    success_steps: float | None
    success_steps_ci: Interval | None
    act_seconds: float | None
    repeats: int
    privileged: str

    @property
    def finished(self) -> int:
        """Episodes that rates count."""
        return self.episodes - self.errors

    def record(self) -> dict[str, Any]:
        """The keys that ``report --json`` promises, and no others."""
        return {
            "agent": self.agent,
            "env": self.env,
            "condition": self.condition,
            "episodes": self.episodes,
            "errors": self.errors,
            "success": self.success,
            "success_ci": _as_list(self.success_ci),
            "complete": self.complete,
            "complete_ci": _as_list(self.complete_ci),
        }


def summaries(collected: Collected) -> list[Summary]:
    """One for each task and agent, in the manifests' order."""
    return [
        summarise(agent, *task.key, rows)
        for task in collected.tasks
        for agent, rows in collected.rows_of(task).items()
    ]


def summarise(agent: str, env: str, condition: str, rows: Sequence[Row]) -> Summary:
    """Summary of one agent's rows on one task."""
    finished = [row for row in rows if row.status == "ok"]
    won = [row for row in finished if row.success]
    complete = math.fsum(row.complete for row in finished)
    return Summary(
        agent=agent,
        env=env,
        condition=condition,
        episodes=len(rows),
        errors=len(rows) - len(finished),
        successes=len(won),
        success=_mean(row.success for row in finished),
        success_ci=wilson(len(won), len(finished)),
        complete=_mean(row.complete for row in finished),
        complete_ci=wilson(complete, len(finished)),
        complete_bootstrap=_bootstrap([row.complete for row in finished], finished),
        success_steps=_mean(row.steps for row in won),
        success_steps_ci=_bootstrap([row.steps for row in won], won),
        act_seconds=_mean(row.act_seconds for row in finished),
        repeats=1 + max((row.repeat for row in rows), default=0),
        privileged=next((row.privileged for row in rows if row.privileged), ""),
    )


def _bootstrap(values: Sequence[float], rows: Sequence[Row]) -> Interval | None:
    return bootstrap_mean(values, [row.seed for row in rows])


def _mean(values: Iterable[float]) -> float | None:
    numbers = list(values)
    return math.fsum(numbers) / len(numbers) if numbers else None


def _as_list(interval: Interval | None) -> list[float] | None:
    return None if interval is None else [interval.low, interval.high]
