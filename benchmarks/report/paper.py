"""The paper's own numbers, to stand beside ours."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from benchmarks.report.summaries import Summary
from benchmarks.statistics import Interval, fisher_p, wilson

_FILE: Final = Path(__file__).with_name("paper.json")
_WAYS: Final = ("-paper", "-improved")
"""What names of our agents end in that run a method with the paper's settings, or with ICD's."""


@dataclass(frozen=True)
class PaperResult:
    """What the paper reports of one method on one task.

    Attributes:
        agent: our name of the method.
        name: the paper's.
        env: id of the environment.
        runs: episodes.
        success: rate in [0, 1].
        complete: mean complete rate in [0, 1], None where the paper has none.
    """

    agent: str
    name: str
    env: str
    runs: int
    success: float
    complete: float | None

    @property
    def successes(self) -> int:
        """Episodes that ended in success."""
        return round(self.success * self.runs)

    @property
    def success_ci(self) -> Interval | None:
        """95 % Wilson interval, which the paper does not give."""
        return wilson(self.successes, self.runs)

    def p_against(self, ours: Summary) -> float | None:
        """Two-sided p-value of "the same success rate"; the scenes are not the same ones."""
        if ours.finished == 0:
            return None
        return fisher_p((ours.successes, ours.finished), (self.successes, self.runs))


@cache
def paper_results() -> tuple[PaperResult, ...]:
    """All numbers of the paper's tables, in its order."""
    content: dict[str, Any] = json.loads(_FILE.read_text(encoding="utf-8"))
    return tuple(
        PaperResult(
            agent=row["agent"],
            name=row["name"],
            env=env,
            runs=content["runs"],
            success=row["success"][i] / 100,
            complete=None if row["complete"][i] is None else row["complete"][i] / 100,
        )
        for table in content["tables"]
        for row in table["rows"]
        for i, env in enumerate(table["tasks"])
    )


def paper_protocol() -> str:
    """How many runs each number stands for."""
    protocol: str = json.loads(_FILE.read_text(encoding="utf-8"))["protocol"]
    return protocol


def method_of(agent: str) -> str:
    """Our name of the method that an agent runs, in its own settings or in others."""
    for way in _WAYS:
        agent = agent.removesuffix(way)
    return agent


def paper_of(env: str, condition: str = "default") -> dict[str, PaperResult]:
    """The paper's results on a task by agent; it has none under other conditions."""
    name = env.rpartition(":")[2]
    if condition != "default":
        return {}
    return {result.agent: result for result in paper_results() if result.env == name}
