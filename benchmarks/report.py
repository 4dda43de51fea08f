"""From rows to rates: what is known about each agent on each environment."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.errors import ResultsError
from benchmarks.manifest import Manifest, read_manifest
from benchmarks.results import read_rows
from benchmarks.rows import Row
from benchmarks.statistics import Interval, wilson


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
        success_steps: mean control steps of the successes.
        act_seconds: [s] mean wall time of one ``act``.
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
    success_steps: float | None
    act_seconds: float | None
    privileged: str

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


def report(folders: Sequence[Path]) -> list[Summary]:
    """Summaries of one or more results folders, by env, then agent, in the manifests' order.

    Raises:
        ResultsError: a folder cannot be read, or two folders disagree about an episode.
        IncompatibleResultsError: a folder of another schema version.
    """
    manifests = [read_manifest(folder) for folder in folders]
    rows = _merge([(folder, read_rows(folder)) for folder in folders])
    keys = dict.fromkeys(
        (agent, *task)
        for task in dict.fromkeys(task.key for manifest in manifests for task in manifest.tasks)
        for agent in dict.fromkeys(agent for manifest in manifests for agent in manifest.agents)
        if any(_planned(manifest, agent, task) for manifest in manifests)
    )
    return [
        summarise(*key, [row for row in rows if (row.agent, row.env, row.condition) == key])
        for key in keys
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
        success_steps=_mean(row.steps for row in won),
        act_seconds=_mean(row.act_seconds for row in finished),
        privileged=next((row.privileged for row in rows if row.privileged), ""),
    )


def _planned(manifest: Manifest, agent: str, task: tuple[str, str]) -> bool:
    return agent in manifest.agents and task in [planned.key for planned in manifest.tasks]


def _merge(folders: Iterable[tuple[Path, list[Row]]]) -> list[Row]:
    """All rows; an episode that several folders hold counts once."""
    seen: dict[tuple[str, str, str, int, int], tuple[Path, Row]] = {}
    for folder, rows in folders:
        for row in rows:
            episode = (row.agent, row.env, row.condition, row.seed, row.repeat)
            other_folder, other = seen.setdefault(episode, (folder, row))
            if row.outcome != other.outcome:
                raise ResultsError(
                    f"{other_folder} and {folder} disagree about agent={row.agent!r} "
                    f"env={row.env!r} condition={row.condition!r} seed={row.seed}: report them "
                    "one by one"
                )
    return [row for _, row in seen.values()]


def _mean(values: Iterable[float]) -> float | None:
    numbers = list(values)
    return math.fsum(numbers) / len(numbers) if numbers else None


def _as_list(interval: Interval | None) -> list[float] | None:
    return None if interval is None else [interval.low, interval.high]
