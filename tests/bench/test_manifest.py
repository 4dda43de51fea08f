"""When a run may go on with results that are there; the file itself is tested in test_results."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.attempt import Settings
from benchmarks.conditions import TaskSpec
from benchmarks.errors import IncompatibleResultsError
from benchmarks.manifest import continued, describe, read_manifest
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
