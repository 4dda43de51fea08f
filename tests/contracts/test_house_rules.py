from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.contracts.house_rules import RULES, Rule, no_clock

ROOT = Path(__file__).parents[2]
PACKAGES = ("icd_envs", "icd_agent", "baselines", "benchmarks")
FILES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
LONGEST = 500
EXEMPT = {
    # Seeds the global generators in worker processes, for agents that draw from them.
    "no_global_random_state": {"benchmarks/generators.py"},
}

OFFENCES = {
    "no_pickle": [
        "import pickle",
        "from cloudpickle import dumps",
        "import numpy as np\nnp.load('x', allow_pickle=True)",
    ],
    "no_eval": ["eval('1')", "exec(text)", "subprocess.run('ls', shell=True)"],
    "safe_torch_load": [
        "torch.load('x')",
        "torch.load('x', weights_only=False)",
        "torch.load('x', weights_only=flag)",
    ],
    "no_global_random_state": [
        "np.random.seed(0)",
        "x = np.random.normal(size=3)",
        "import random",
        "from random import choice",
        "torch.manual_seed(0)",
        "rng = np.random.default_rng()",
    ],
    "no_pass_through": [
        "def f(a, **kwargs): ...",
        "f = lambda **kw: kw",
        "class EnvFactory:\n    def make(self, **options): ...",
        "class Other:\n    def __call__(self, **options): ...",
    ],
    "no_bare_except": ["try:\n    f()\nexcept:\n    pass"],
    "no_clock": ["import time", "from time import monotonic", "from datetime import datetime"],
}

INNOCENT = """
import numpy as np
import torch
from numpy.random import Generator
rng = np.random.default_rng(np.random.SeedSequence(3))
weights = torch.load("x", weights_only=True)
table = np.load("x", allow_pickle=False)
def f(rng: np.random.Generator, *args): return dict(**table)
try:
    f(rng)
except ValueError:
    pass
"""


def offences(rule: Rule, files: list[Path]) -> list[str]:
    """Where files break a rule."""
    return [
        f"{path.relative_to(ROOT)}:{line}: {what}"
        for path in files
        for line, what in rule(ast.parse(path.read_text(encoding="utf-8")))
    ]


def test_there_are_files_of_every_package() -> None:
    assert {path.relative_to(ROOT).parts[0] for path in FILES} == set(PACKAGES)


@pytest.mark.parametrize("rule", RULES)
def test_no_file_breaks_a_rule(rule: Rule) -> None:
    exempt = EXEMPT.get(rule.__name__, set())
    files = [path for path in FILES if path.relative_to(ROOT).as_posix() not in exempt]
    assert len(files) == len(FILES) - len(exempt)
    assert offences(rule, files) == []


def test_no_environment_looks_at_the_clock() -> None:
    assert offences(no_clock, [path for path in FILES if "icd_envs" in path.parts]) == []


def test_no_file_is_longer_than_a_reader_can_hold() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    assert {str(path): lines for path, lines in lengths.items() if lines > LONGEST} == {}


@pytest.mark.parametrize("rule", [*RULES, no_clock])
def test_rule_finds_what_it_should_and_nothing_else(rule: Rule) -> None:
    for text in OFFENCES[rule.__name__]:
        assert list(rule(ast.parse(text))), text
    assert list(rule(ast.parse(INNOCENT))) == []
