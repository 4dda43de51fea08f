"""Rows of the expert and of copied goals, on the real tasks."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.attempt import Attempt
from benchmarks.expert_runs import CopiedGoals, ExpertRuns, RoutesAll
from benchmarks.plan import Job
from benchmarks.pulse import Pulse
from benchmarks.rows import Row
from benchmarks.suites import CONTACT_GOALS
from icd_envs.tasks.cable_routing import CableRouting
from icd_envs.tasks.problem import draw_problem, scene_rng

CABLE = "ICDCableRouting-v0"
NOTEBOOK = "ICDNotebookFolding-v0"
SEEDS = range(6)


def play(source: ExpertRuns | CopiedGoals | RoutesAll, job: Job) -> Row:
    return source.work(1).do(Attempt(job), Pulse()).row


@pytest.mark.parametrize("env_id", [CABLE, NOTEBOOK])
def test_goal_copied_into_its_own_scene_is_reached(env_id: str) -> None:
    row = play(CopiedGoals("goal-copied", 1), Job("goal-copied", env_id, 0, seed=0))
    assert (row.status, row.success, row.complete, row.steps) == ("ok", True, 1.0, 0)


def test_goal_copied_into_another_scene_is_not() -> None:
    source, env_id = CopiedGoals("goal-copied", 3), "ICDCableRoutingAdaptation-v0"
    rows = [play(source, Job(source.agent, env_id, i, seed=i)) for i in range(3)]
    assert {row.status for row in rows} == {"ok"}
    assert not all(row.success for row in rows)


def test_routing_everywhere_reaches_the_contact_goals_that_ask_for_it() -> None:
    source = RoutesAll("expert-routes-all", len(SEEDS), CONTACT_GOALS)
    task = CableRouting(goals="contact")
    asked = []
    for seed in SEEDS:
        row = play(source, Job(source.agent, CABLE, seed, seed, CONTACT_GOALS))
        contacts = draw_problem(task, scene_rng("test", seed), seed).scene.contacts
        asked.append(set(contacts) == {"through"})
        assert row.condition == CONTACT_GOALS.name
        assert row.success == asked[-1]
        assert row.complete == contacts.count("through") / len(contacts)
    assert set(asked) == {True, False}


def test_expert_runs_are_the_demonstrations_and_errors_become_rows() -> None:
    source = ExpertRuns("expert-clean", split="test", noisy=False, episodes=1)
    job = Job(source.agent, CABLE, 0, seed=0)
    row = play(source, job)
    assert (row.success, row.complete, row.diverged) == (True, 1.0, False)
    assert 100 < row.steps <= 300
    lost = play(source, replace(job, env="Nowhere-v0"))
    assert lost.status == "error"
    assert "Nowhere-v0" in lost.message
