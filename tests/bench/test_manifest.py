"""When a run may go on with results that are there; the file itself is tested in test_results."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.attempt import Settings
from benchmarks.conditions import TaskSpec
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.manifest import FILE_NAME, continued, describe, read_manifest
from benchmarks.plan import Plan
from benchmarks.results import open_results
from icd_envs.errors import InvalidOptionError

PLAN = Plan(agents=("a",), tasks=(TaskSpec("E-v0"),), episodes=3)
OLD = replace(describe(PLAN, {"act_seconds": 60.0, "a": "mine.py sha256:1"}), code="sha256:0")
NEW = replace(OLD, code="sha256:2", packages={**OLD.packages, "mujoco": "0.1"})


def test_settings_survive_the_file(tmp_path: Path) -> None:
    OLD.write(tmp_path)
    assert read_manifest(tmp_path) == OLD
    assert OLD.settings == {"act_seconds": 60.0, "a": "mine.py sha256:1"}


@pytest.mark.parametrize(
    ("settings", "reason"),
    [({"act_seconds": 9.0}, "act_seconds: 60.0 there, 9.0 now"), ({"a": "gone"}, "a: 'mine.py")],
)
def test_other_settings_are_refused_unless_mixing_is_allowed(
    settings: dict[str, str | float], reason: str
) -> None:
    new = replace(OLD, settings={**OLD.settings, **settings})
    with pytest.raises(IncompatibleResultsError, match=f"{reason}.*--allow-mixed"):
        continued(OLD, new)
    (difference,) = continued(OLD, new, allow_mixed=True).mixed
    assert difference.startswith(reason)


def test_every_difference_that_was_allowed_is_kept_for_ever() -> None:
    mixed = continued(OLD, NEW, allow_mixed=True)
    assert (mixed.code, mixed.created) == (NEW.code, OLD.created)
    assert len(mixed.mixed) == 2
    assert continued(mixed, NEW).mixed == mixed.mixed
    assert continued(mixed, OLD, allow_mixed=True).mixed[:2] == mixed.mixed


def test_agent_that_joins_brings_its_settings_and_leaves_those_of_the_others() -> None:
    more = replace(OLD, agents=("a", "b"), settings={"act_seconds": 60.0, "b": "theirs 1.0"})
    assert continued(OLD, more).settings == {**OLD.settings, "b": "theirs 1.0"}
    assert continued(OLD, more).mixed == ()


def test_python_and_processor_may_change_and_are_kept() -> None:
    moved = replace(OLD, python="3.99", cpu_model="abacus")
    mixed = continued(OLD, moved).mixed
    assert [text.partition(":")[0] for text in mixed] == ["python", "processor"]
    back = replace(continued(continued(OLD, moved), OLD), mixed=mixed)
    assert continued(back, moved).mixed == mixed


def test_changes_that_were_not_committed_stay_told() -> None:
    assert continued(replace(OLD, dirty=True), replace(NEW, dirty=False), allow_mixed=True).dirty
    assert not continued(replace(OLD, dirty=False), replace(OLD, dirty=False)).dirty


def test_package_that_an_older_version_did_not_name_is_no_difference() -> None:
    fewer = {name: version for name, version in OLD.packages.items() if name != "torch"}
    assert "torch" in OLD.packages
    assert continued(replace(OLD, packages=fewer), OLD).mixed == ()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("episodes", "3"), ("seed", None), ("repeats", 1.5), ("dirty", "no"), ("agents", [1]),
        ("packages", None), ("weights", {"a": 1}), ("settings", [1]), ("wall_seconds", "long"),
    ],
)  # fmt: skip
def test_field_of_a_wrong_type_is_named(tmp_path: Path, field: str, value: object) -> None:
    record = {**json.loads(OLD.to_json()), field: value}
    (tmp_path / FILE_NAME).write_text(json.dumps(record))
    with pytest.raises(ResultsError, match=f"is not a manifest: .*{field}"):
        read_manifest(tmp_path)


@pytest.mark.parametrize("plan", [replace(PLAN, seed=1), replace(PLAN, episodes=2)])
def test_episodes_of_another_plan_are_never_mixed(tmp_path: Path, plan: Plan) -> None:
    with open_results(tmp_path, PLAN, resume=False):
        pass
    with (
        pytest.raises(IncompatibleResultsError, match="cannot resume"),
        open_results(tmp_path, plan, resume=True, allow_mixed=True),
    ):
        pass


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("inf"), float("nan")])
def test_budgets_that_nothing_could_keep_are_refused(seconds: float) -> None:
    with pytest.raises(InvalidOptionError, match="episode_seconds must be positive and finite"):
        Settings(episode_seconds=seconds)
    assert "threads" not in Settings().record()
