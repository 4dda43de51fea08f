"""A first look at agents, whatever importing them does."""

import os
from pathlib import Path

import pytest

from benchmarks.examination import examine
from benchmarks.executors import Local
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
