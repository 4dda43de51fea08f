"""What is shown while episodes run."""

import re

import pytest

from benchmarks.progress import watching
from tests.bench.making import make_row


def shown(capsys: pytest.CaptureFixture[str], agents: str, finished: int = 0) -> list[str]:
    """Lines on stderr of a run of one episode for each agent of a word, won if its letter is w."""
    rows = [
        make_row(agent=a, index=i, success=a == "w", status="error" if a == "e" else "ok")
        for i, a in enumerate(agents)
    ]
    with watching("toys")(len(rows), rows[:finished]) as seen:
        for row in rows[finished:]:
            seen(row)
    return capsys.readouterr().err.splitlines()


def test_rates_are_those_of_each_agent_and_errors_are_apart(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert shown(capsys, "ww")[-1] == "toys: 2/2 episodes, success 2/2"
    assert shown(capsys, "wwle")[-1] == "toys: 4/4 episodes, success w 2/2, l 0/1, e 0/0, 1 errors"
    assert shown(capsys, "abcdw")[-1] == "toys: 5/5 episodes, success 1/5"


def test_long_runs_print_few_lines_with_the_time_left(capsys: pytest.CaptureFixture[str]) -> None:
    lines = shown(capsys, "w" * 1000, finished=500)
    assert len(lines) == 5
    assert re.fullmatch(r"toys: 600/1000 episodes, success 600/600, 0:00:0\d left", lines[0])
