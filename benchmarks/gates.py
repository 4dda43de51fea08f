"""Difficulty gates: what must hold of a task before its numbers mean anything."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from benchmarks.attempt import Settings
from benchmarks.conditions import DEFAULT, Condition, TaskSpec
from benchmarks.executors import Executor
from benchmarks.expert_runs import CopiedGoals, ExpertRuns, RoutesAll
from benchmarks.plan import Plan
from benchmarks.registry import agent_factory
from benchmarks.rows import Row
from benchmarks.runner import Episodes, Watch, episodes, run
from benchmarks.suites import CONTACT_GOALS
from icd_envs.errors import InvalidOptionError, unknown_name
from icd_envs.registration import check_env_id

Bound = float | tuple[float, float]


@dataclass(frozen=True)
class AgentRuns:
    """Episodes of an agent, run as ``icd-bench run`` does.

    Attributes:
        agent: its name.
        episodes: how many.
        condition: what the task is put under.
    """

    agent: str
    episodes: int
    condition: Condition = DEFAULT

    def work(self, threads: int) -> Episodes:
        """What does one of its jobs; an agent that cannot be imported is an error here."""
        agent_factory(self.agent)
        return episodes(Settings(threads=threads))


@dataclass(frozen=True)
class Gate:
    """One condition on the rows of one source.

    Attributes:
        name: key of the verdict.
        source: where the rows come from; gates with an equal source share its rows.
        quantity: success rate, mean complete rate, or number of diverged episodes.
        direction: how the quantity must compare with the bound.
        bound: a number, or (low, high), both included, for the direction "in".
    """

    name: str
    source: AgentRuns | ExpertRuns | CopiedGoals | RoutesAll
    quantity: Literal["success", "complete", "divergences"]
    direction: Literal[">=", "<=", "==", "in"]
    bound: Bound


@dataclass(frozen=True)
class Verdict:
    """Whether a gate holds.

    Attributes:
        value: the quantity, None without a finished episode.
        bound: of the gate.
        n: finished episodes; those with an error do not count.
        ok: the value is within the bound and no planned episode is missing or had an error.
    """

    value: float | None
    bound: Bound
    n: int
    ok: bool

    def record(self) -> dict[str, Any]:
        """The keys that ``gates --json`` promises, and no others."""
        bound = list(self.bound) if isinstance(self.bound, tuple) else self.bound
        return {"value": self.value, "bound": bound, "n": self.n, "ok": self.ok}


_EXPERT = ExpertRuns("expert-clean", split="test", noisy=False, episodes=200)
_PC_MPPI = AgentRuns("pc-mppi", episodes=20)
_COMMON = (
    Gate(
        "oracle_points_success",
        AgentRuns("ladder:oracle-points", episodes=20),
        "success",
        ">=",
        0.95,
    ),
    Gate(
        "noisy_divergences",
        ExpertRuns("expert-noisy", split="train", noisy=True, episodes=1000),
        "divergences",
        "==",
        0,
    ),
)
_CONTACT = (
    Gate(
        "contact_routes_all",
        RoutesAll("expert-routes-all", 200, CONTACT_GOALS),
        "success",
        "<=",
        0.40,
    ),
)
_ADAPTATION = (
    Gate("expert_success", _EXPERT, "success", ">=", 0.85),
    Gate("copied_goal_success", CopiedGoals("goal-copied", 200), "success", "<=", 0.50),
    Gate(
        "transferred_points_success",
        AgentRuns("ladder:transferred-points", episodes=20),
        "success",
        "<=",
        0.40,
    ),
)

GATES: dict[str, tuple[Gate, ...]] = {
    "ICDCableRouting-v0": (
        Gate("expert_success", _EXPERT, "success", ">=", 0.85),
        Gate("pc_mppi_success", _PC_MPPI, "success", "<=", 0.60),
        Gate("pc_mppi_complete", _PC_MPPI, "complete", "in", (0.30, 0.75)),
        *_COMMON,
        *_CONTACT,
    ),
    "ICDNotebookFolding-v0": (
        Gate("expert_success", _EXPERT, "success", ">=", 0.90),
        Gate("pc_mppi_success", _PC_MPPI, "success", "in", (0.25, 0.75)),
        *_COMMON,
    ),
    "ICDCableRoutingAdaptation-v0": (*_ADAPTATION, *_COMMON, *_CONTACT),
    "ICDNotebookFoldingAdaptation-v0": (*_ADAPTATION, *_COMMON),
}


def gates_of(env_id: str, only: Sequence[str] = ()) -> list[Gate]:
    """Gates of an environment, or those of them that are named.

    Raises:
        InvalidOptionError: the environment has no gates, or none of that name.
    """
    if env_id not in GATES:
        raise InvalidOptionError(f"no gates for it: {unknown_name('env', env_id, GATES)}")
    gates = {gate.name: gate for gate in GATES[env_id]}
    for name in only:
        if name not in gates:
            raise InvalidOptionError(unknown_name("gate", name, gates))
    return [gate for gate in gates.values() if not only or gate.name in only]


def run_gates(
    env_id: str,
    gates: Sequence[Gate],
    out: Path,
    executor: Executor,
    *,
    resume: bool,
    watch: Callable[[str], Watch],
) -> dict[str, Verdict]:
    """Run the sources of the gates, each into its folder below ``out/rows``, and judge.

    Args:
        env_id: the environment.
        gates: from ``gates_of``.
        out: folder of all the gates' results.
        executor: who runs the episodes.
        resume: go on with results that are there.
        watch: makes the progress of a run from its label.

    Raises:
        ResultsError: a folder cannot be used.
        InvalidOptionError: environment or agent cannot be imported; nothing was run.
    """
    check_env_id(env_id)
    sources = dict.fromkeys(gate.source for gate in gates)
    works = {source: source.work(executor.threads) for source in sources}
    rows = {
        source: run(
            Plan((source.agent,), (TaskSpec(env_id, source.condition),), source.episodes),
            out / "rows" / source.agent.replace(":", "-"),
            work,
            executor,
            resume=resume,
            watch=watch(source.agent),
        )
        for source, work in works.items()
    }
    return {gate.name: judge(gate, rows[gate.source]) for gate in gates}


def judge(gate: Gate, rows: Sequence[Row]) -> Verdict:
    """Compare the rows of a gate's source with its bound."""
    finished = [row for row in rows if row.status == "ok"]
    n = len(finished)
    value: float | None
    if n == 0:
        value = None
    elif gate.quantity == "success":
        value = sum(row.success for row in finished) / n
    elif gate.quantity == "complete":
        value = sum(row.complete for row in finished) / n
    else:
        value = sum(row.diverged for row in finished)
    within = value is not None and _within(value, gate)
    return Verdict(value, gate.bound, n, ok=within and n >= gate.source.episodes)


def _within(value: float, gate: Gate) -> bool:
    if isinstance(gate.bound, tuple):
        return gate.bound[0] <= value <= gate.bound[1]
    return {">=": value >= gate.bound, "<=": value <= gate.bound, "==": value == gate.bound}[
        gate.direction
    ]
