"""A first look at agents, whatever importing them does."""

import os
from pathlib import Path

import pytest

from benchmarks.attempt import Settings
from benchmarks.conditions import TaskSpec
from benchmarks.errors import ResultsWarning
from benchmarks.examination import examine
from benchmarks.executors import Local
from benchmarks.plan import Plan
from benchmarks.run_command import look_first
from tests.bench import toy


def test_agents_that_do_harm_when_imported_are_told_from_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leaves.py").write_text("import os\nos._exit(7)")
    (tmp_path / "dies.py").write_text("import os\nos.kill(os.getpid(), 11)")
    (tmp_path / "raises.py").write_text("1 / 0")
    bad = {
        "leaves.py:Agent": "worker died (exit status 7)",
        "dies.py:Agent": "worker died (signal 11)",
        "raises.py:Agent": "ZeroDivisionError",
        "no-such-agent": "unknown agent",
    }
    good = toy.spec(toy.Straight)
    first, *others = examine([good, *bad], Local(2))
    assert (first.name, first.problem) == (good, "")
    assert "sha256:" in first.origin
    for examined, (name, problem) in zip(others, bad.items(), strict=True):
        assert examined.name == name
        assert problem in examined.problem
        assert name in examined.problem
    assert os.getcwd() == str(tmp_path)


def test_agents_that_cannot_be_made_and_environments_neither_are_told(tmp_path: Path) -> None:
    file = tmp_path / "needy.py"
    file.write_text(
        "class Needy:\n"
        "    def __init__(self, env_id): raise OSError(f'no weights for {env_id}')\n"
        "    def reset(self, episode, seed): pass\n"
        "    def act(self, observation): pass\n"
    )
    good, needy = toy.spec(toy.Straight), f"{file}:Needy"
    settings = Settings(episode_seconds=60.0)
    sound, broken = examine([good, needy], Local(2), [TaskSpec(toy.ENV)], settings)
    assert sound.problem == ""
    assert f"making it for {toy.ENV}: OSError: no weights for {toy.ENV}" in broken.problem
    (nowhere,) = examine([good], Local(1), [TaskSpec("CartPole-v1")], settings)
    assert "making CartPole-v1: TypeError" in nowhere.problem
    (ours,) = examine(["random"], Local(1), [TaskSpec(toy.ENV)], settings)
    assert (ours.origin, ours.problem) == ("", "")


def test_who_is_given_a_device_that_it_does_not_take_is_named(tmp_path: Path) -> None:
    file = tmp_path / "takes.py"
    file.write_text(
        "class Takes:\n"
        "    def __init__(self, device): assert device == 'cuda:7'\n"
        "    def reset(self, episode, seed): pass\n"
        "    def act(self, observation): pass\n"
    )
    names = (toy.spec(toy.Straight), f"{file}:Takes", "random")
    plan = Plan(names, (TaskSpec(toy.ENV),), 1)
    with pytest.warns(ResultsWarning, match="on the CPU: cuda:7 is not used") as told:
        look_first(plan, Local(2), Settings(device="cuda:7"), None)
    assert [str(each.message).split()[0] for each in told] == [names[0], "random"]
