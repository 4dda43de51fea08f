"""Names of agents and environments."""

import sys
from pathlib import Path

import pytest

from benchmarks import registry
from icd_envs.errors import InvalidOptionError
from tests.bench import toy


def test_module_attr_finds_class_and_factory() -> None:
    assert isinstance(registry.make_agent(toy.spec(toy.Straight)), toy.Straight)
    assert isinstance(registry.make_agent(toy.spec("make_straight")), toy.Straight)


def test_built_in_names_are_looked_up_in_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry.AGENTS, "ladder:toy", toy.spec(toy.Straight))
    assert isinstance(registry.make_agent("ladder:toy"), toy.Straight)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pc-mpi", "did you mean 'pc-mppi'"),
        ("ladder:oracle-point", "did you mean 'ladder:oracle-points'"),
        ("tests.bench.toy:Strait", "did you mean 'Straight'"),
        ("tests.bench.toy:Unready", "act"),
        ("tests.bench.toy:MAX_STEPS", "name a factory"),
        ("", "valid: 'expert'"),
        (":", "valid: 'expert'"),
    ],
)
def test_wrong_name_is_explained(name: str, message: str) -> None:
    with pytest.raises(InvalidOptionError, match=message):
        registry.agent_factory(name)


def test_broken_import_is_explained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken_toy_agent.py").write_text("import no_such_module_anywhere\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    with pytest.raises(InvalidOptionError, match="no_such_module_anywhere"):
        registry.agent_factory("broken_toy_agent:Agent")


def test_factory_that_makes_no_agent_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(toy, "make_straight", lambda: toy.Unready())
    with pytest.raises(InvalidOptionError, match="made Unready"):
        registry.make_agent(toy.spec("make_straight"))


def test_env_id_is_checked_before_the_first_episode() -> None:
    registry.check_env_id(toy.ENV)
    with pytest.raises(InvalidOptionError, match="did you mean 'ICDCableRouting-v0'"):
        registry.check_env_id("ICDCableRoutin-v0")
