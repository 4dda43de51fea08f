"""A moment in words."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from benchmarks.watch.session import Moment
from benchmarks.watch.text import NAMES, describe
from icd_envs.api import PlanView

NOTHING: Any = {}
MOMENT = Moment(3, 42, 7, 300, NOTHING, success=False, complete_rate=0.5)


def test_every_name_has_its_value() -> None:
    said = describe(MOMENT)
    assert tuple(said) == NAMES
    assert said == {
        "episode": "3 (seed 42)",
        "step": "7 of 300",
        "success": "no",
        "complete": "50%",
        "plan": "none shown",
        "end": "not yet",
    }


def test_success_plan_and_end_are_told() -> None:
    said = describe(replace(MOMENT, success=True, end="success", plan=PlanView(status="fine")))
    assert (said["success"], said["end"], said["plan"]) == ("yes", "success", "fine")
