"""Environments by name in a fresh process; agents, suites and options are tested with the CLI."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    ("env_id", "answer"),
    [
        ("icd_envs:ICDCableRouting-v0", "ICDCableRouting-v0"),
        ("icd_envs:ICDCableRoutin-v0", "Did you mean: `ICDCableRouting`?"),
        ("ICDCableRouting-v0", "Environment `ICDCableRouting` doesn't exist"),
    ],
)
def test_environment_is_made_without_an_import_or_the_mistake_is_named(
    env_id: str, answer: str
) -> None:
    code = f"import gymnasium; print(gymnasium.make('{env_id}').spec.id)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert answer in (done.stdout or done.stderr)
