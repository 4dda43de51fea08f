"""``icd-bench diagnose ends``: last subgoals for goals of another scene."""

from __future__ import annotations

import json
from typing import Any

import pytest

from benchmarks import contact_env
from benchmarks.conditions import TaskSpec, make_env
from icd_agent.weights import LOCAL, SUBGOAL_DIFFUSER, shipped_folder
from tests.bench.making import icd_bench
from tests.envs.making import CABLE

ADAPTATION = "ICDCableRoutingAdaptation-v0"


def ends(*arguments: object) -> dict[str, Any]:
    command = ("diagnose", "ends", "--env", ADAPTATION, "--chains", 3, *arguments, "--json")
    found = icd_bench(*command)
    assert found.exit_code == 0, found.stderr
    values: dict[str, Any] = json.loads(found.stdout)
    return values


def test_ends_are_right_where_the_goal_itself_is_not() -> None:
    values = ends("--scenes", 3)
    assert values["scenes"] == values["chains"] == 3
    assert values["right"] > 0.5
    assert values["goal_right"] == 0


def test_it_takes_weights_of_ones_own() -> None:
    scene = ("--scenes", 1, "--seed", 2)  # where those on the local field get no end right
    assert ends(*scene, "--weights", shipped_folder(CABLE, LOCAL))["right"] < 0.5
    assert ends(*scene)["right"] > 0.5


def test_it_takes_options_of_the_task(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []

    def making(task: TaskSpec) -> object:
        made.append(task)
        return make_env(task)

    monkeypatch.setattr(contact_env, "make_env", making)
    values = ends("--scenes", 1, "--option", "goals=contact")
    assert 0 <= values["right"] <= 1
    (task,) = made
    assert (task.env, task.condition.options) == (ADAPTATION, (("goals", "contact"),))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--env", CABLE), "give an adaptation task"),
        (("--env", "ICDCableRoutingAdaption-v0"), "did you mean"),
        (("--env", ADAPTATION, "--option", "goal=contact"), "goals"),
    ],
)
def test_it_refuses_in_one_line(arguments: tuple[str, ...], message: str) -> None:
    refused = icd_bench("diagnose", "ends", "--scenes", 1, *arguments)
    assert refused.exit_code == 2
    assert message in refused.stderr


def test_the_ends_of_a_model_without_descriptors_are_judged_alike() -> None:
    values = ends("--scenes", 1, "--agent", "subgoal-diffuser")
    assert values["rights"] == str(round(3 * values["right"]))
    weights = shipped_folder(CABLE, SUBGOAL_DIFFUSER)
    assert ends("--scenes", 1, "--agent", "subgoal-diffuser", "--weights", weights) == values
    assert ends("--scenes", 1)["right"] != values["right"]
