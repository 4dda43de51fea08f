"""What ``icd-bench reproduce`` does: run recorded episodes again, and compare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.attempt import Settings
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
    return "ends alike" if ends_alike(recorded, now) else "ENDS DIFFERENTLY"


def ends_alike(recorded: Row, now: Row) -> bool:
    """Whether both ended, and both in success or both in failure."""
    return recorded.status == now.status == "ok" and recorded.success == now.success


class Recorded(NamedTuple):
    """What is to be run again.

    Attributes:
        plan: of its first test cases.
        manifest: of what it is the beginning of.
        rows: of all of it.
    """

    plan: Plan
    manifest: Manifest
    rows: list[Row]

    def settings(self, threads: int, device: str | None, *, trust_pickle: bool) -> Settings:
        """What agents were given, as far as it was recorded.

        Args:
            threads: for simulators; results do not depend on it.
            device: instead of the recorded one.
            trust_pickle: whether agents may be unpickled.

        Raises:
            ResultsError: the manifest's settings cannot be used.
        """
        told, usual = self.manifest.settings, Settings()
        try:
            return Settings(
                threads,
                float(told.get("act_seconds", usual.act_seconds)),
                float(told.get("episode_seconds", usual.episode_seconds)),
                device or str(told.get("device", usual.device)),
                trust_pickle,
            )
        except ValueError as error:
            raise ResultsError(f"the manifest's settings cannot be used: {error}") from error

    def changed(self, told: Mapping[str, str | float]) -> list[str]:
        """What is not as it was: code, versions, settings, files of agents, processor.

        Args:
            told: settings of now, with the origins of agents.
        """
        now = describe(self.plan, told)
        found = list(what_differs(self.manifest, now))
        if self.manifest.cpu_model != now.cpu_model:
            found.append(f"processor: {self.manifest.cpu_model!r} there, {now.cpu_model!r} now")
        return found

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
    return Recorded(plan, manifest, rows)


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
