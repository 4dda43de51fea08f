"""Difficulty gates, on the toy task and a toy expert."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from benchmarks.executors import InProcess
from benchmarks.expert_runs import ExpertRuns
from benchmarks.gates import GATES, AgentRuns, Gate, gates_of, judge, run_gates
from benchmarks.progress import watching
from benchmarks.registry import AGENTS
from benchmarks.results import ROWS_NAME, read_rows
from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError
from tests.bench import toy
from tests.bench.making import make_row

CABLE = "ICDCableRouting-v0"


def gate(direction: str, bound: object, quantity: str = "success", n: int = 4) -> Gate:
    return Gate("g", AgentRuns("a", n), quantity, direction, bound)


COMMON = {
    "oracle_points_success": ("success", ">=", 0.95, 20),
    "noisy_divergences": ("divergences", "==", 0, 1000),
}
ADAPTATION = {
    "expert_success": ("success", ">=", 0.85, 200),
    "copied_goal_success": ("success", "<=", 0.50, 200),
    "transferred_points_success": ("success", "<=", 0.40, 20),
}
CONTACT = {"contact_routes_all": ("success", "<=", 0.40, 200)}
DESCRIBED = {
    CABLE: {
        "expert_success": ("success", ">=", 0.85, 200),
        "pc_mppi_success": ("success", "<=", 0.60, 20),
        "pc_mppi_complete": ("complete", "in", (0.30, 0.75), 20),
        **COMMON,
        **CONTACT,
    },
    "ICDNotebookFolding-v0": {
        "expert_success": ("success", ">=", 0.90, 200),
        "pc_mppi_success": ("success", "in", (0.25, 0.75), 20),
        **COMMON,
    },
    "ICDCableRoutingAdaptation-v0": {**ADAPTATION, **COMMON, **CONTACT},
    "ICDNotebookFoldingAdaptation-v0": {**ADAPTATION, **COMMON},
}


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_every_task_has_the_gates_of_its_description(env_id: str) -> None:
    found = {
        g.name: (g.quantity, g.direction, g.bound, g.source.episodes) for g in gates_of(env_id)
    }
    assert found == DESCRIBED[env_id]


def test_gate_rows_do_not_mix_experts() -> None:
    sources = {g.source.agent for gates in GATES.values() for g in gates}
    assert len(sources) == len({g.source for gates in GATES.values() for g in gates})


def test_agents_of_the_gates_are_known() -> None:
    found = [g.source for gates in GATES.values() for g in gates]
    agents = {source.agent for source in found if isinstance(source, AgentRuns)}
    assert agents == {"pc-mppi", "ladder:oracle-points", "ladder:transferred-points"}
    assert agents <= set(AGENTS)


@pytest.mark.parametrize(
    ("gate_", "value", "ok"),
    [
        (gate(">=", 0.5), 0.5, True),
        (gate(">=", 0.51), 0.5, False),
        (gate("<=", 0.5), 0.5, True),
        (gate("<=", 0.4), 0.5, False),
        (gate("in", (0.7, 0.8), "complete"), 0.75, True),
        (gate("in", (0.8, 0.9), "complete"), 0.75, False),
        (gate("==", 0, "divergences"), 1, False),
        (gate("==", 1, "divergences"), 1, True),
        (gate(">=", 0.5, n=5), 0.5, False),
    ],
)
def test_gate_is_judged_by_value_and_number(gate_: Gate, value: float, ok: bool) -> None:
    rows = [
        make_row(index=i, success=i < 2, complete=1.0 if i < 2 else 0.5, diverged=i == 3)
        for i in range(4)
    ]
    verdict = judge(gate_, rows)
    assert (verdict.value, verdict.n, verdict.ok) == (value, 4, ok)
    assert list(verdict.record()) == ["value", "bound", "n", "ok"]


def test_gate_with_an_error_is_not_ok() -> None:
    rows = [make_row(index=i, success=True) for i in range(3)]
    verdict = judge(gate(">=", 0.5), [*rows, make_row(index=3, status="error", message="boom")])
    assert (verdict.value, verdict.n, verdict.ok) == (1.0, 3, False)
    assert judge(gate("<=", 0.5), []).record() == {"value": None, "bound": 0.5, "n": 0, "ok": False}


def test_unknown_names_are_explained() -> None:
    with pytest.raises(InvalidOptionError, match=f"no gates.*{CABLE}"):
        gates_of("CartPole-v1")
    with pytest.raises(InvalidOptionError, match="did you mean 'expert_success'"):
        gates_of(CABLE, ["expert_sucess"])
    assert [g.name for g in gates_of(CABLE, ["pc_mppi_success"])] == ["pc_mppi_success"]


def test_gates_run_agents_and_experts_once_and_resume(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def demonstrate(env_id: str, *, seed: int, split: str, noisy: bool) -> SimpleNamespace:
        asked.append((env_id, seed, split, noisy))
        if len(asked) == 3:
            raise RuntimeError("expert stumbled")
        return SimpleNamespace(success=True, complete_rate=1.0, diverged=False, steps=9)

    module = ModuleType("icd_envs.demonstrations")
    module.demonstrate = demonstrate
    monkeypatch.setitem(sys.modules, "icd_envs.demonstrations", module)
    straight = AgentRuns(toy.spec(toy.Straight), 3)
    expert = ExpertRuns("expert-noisy", split="train", noisy=True, episodes=5)
    gates = [
        Gate("success", straight, "success", ">=", 0.9),
        Gate("complete", straight, "complete", "in", (0.0, 0.5)),
        Gate("expert", expert, "divergences", "==", 0),
    ]

    def verdicts() -> dict[str, tuple]:
        judged = run_gates(toy.ENV, gates, tmp_path, InProcess(), resume=True, watch=watching)
        return {name: (v.value, v.n, v.ok) for name, v in judged.items()}

    first = verdicts()
    assert first == {"success": (1, 3, True), "complete": (1, 3, False), "expert": (0, 4, False)}
    assert {call[2:] for call in asked} == {("train", True)}
    assert len(set(asked)) == 5
    assert verdicts() == first
    assert len(asked) == 5
    assert [
        row.message for row in read_rows(tmp_path / "rows" / "expert-noisy") if row.message
    ] == ["expert-noisy: RuntimeError: expert stumbled"]
    assert len(list(tmp_path.glob(f"rows/*/{ROWS_NAME}"))) == 2


def test_agent_that_cannot_be_imported_fails_before_anything_runs(tmp_path: Path) -> None:
    gates = [
        Gate("good", AgentRuns(toy.spec(toy.Straight), 1), "success", ">=", 0.0),
        Gate("bad", AgentRuns(toy.spec("Nobody"), 1), "success", ">=", 0.0),
    ]
    with pytest.raises(InvalidOptionError, match="Nobody"):
        run_gates(toy.ENV, gates, tmp_path, InProcess(), resume=True, watch=watching)
    assert list(tmp_path.iterdir()) == []
