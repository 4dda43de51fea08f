"""The measurement of two workers, on toys: its figures mean nothing, its rows agree."""

import re
import subprocess
import sys

import pytest

from tests.bench import toy


@pytest.mark.slow
def test_both_runs_are_timed_and_their_rows_compared() -> None:
    task = ["--agent", toy.spec(toy.Drunk), "--env", toy.ENV, "--episodes", "2"]
    command = [sys.executable, "-m", "benchmarks.perf.workers", *task]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)
    figures = re.search(r"one worker (\S+) s, two workers (\S+) s, ratio (\S+), ", done.stdout)
    assert figures is not None, done.stderr
    one, two, ratio = map(float, figures.groups())
    assert ratio == pytest.approx(two / one, rel=0.1)
    assert done.returncode == (ratio > 0.6)
    assert "differ" not in done.stdout
