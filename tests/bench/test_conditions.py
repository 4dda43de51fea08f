"""Conditions: what they refuse, and how they are written down."""

import json

import pytest

from benchmarks.conditions import Condition, TaskSpec, make_env, task_from_record
from icd_envs.errors import InvalidOptionError


def test_record_survives_json() -> None:
    condition = Condition("c", (("cable", "rope"), ("num_fixtures", 3)), 0.1, 0.2, 2.0, 0.5, 0.7)
    task = TaskSpec("E-v0", condition)
    assert task_from_record(json.loads(json.dumps(task.record()))) == task


@pytest.mark.parametrize(
    "field",
    ["action_noise", "observation_noise", "planner_stiffness", "planner_mass", "planner_friction"],
)
def test_values_out_of_range_are_refused(field: str) -> None:
    for value in (-0.1, float("nan"), float("inf")):
        with pytest.raises(InvalidOptionError, match=field):
            Condition(**{field: value})


def test_options_reach_the_environment_and_misspelt_ones_are_answered() -> None:
    env = make_env(TaskSpec("ICDCableRouting-v0", Condition("c", (("num_fixtures", 3),))))
    assert env.get_wrapper_attr("task").num_fixtures == 3
    assert env.get_wrapper_attr("split") == "test"
    with pytest.raises(InvalidOptionError, match="did you mean 'num_fixtures'"):
        make_env(TaskSpec("ICDCableRouting-v0", Condition("c", (("num_fixture", 3),))))
