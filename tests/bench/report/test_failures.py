"""Endings in a few words."""

import pytest

from benchmarks.report.failures import count_endings, ending
from tests.bench.making import make_row


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"success": True, "complete": 1.0}, "success"),
        ({"complete": 0.5}, "out of steps, 50 % complete"),
        ({"complete": 1 / 3}, "out of steps, 33 % complete"),
        ({"diverged": True, "complete": 0.0}, "the physics diverged"),
        ({"message": "act, step 3: ValueError: no 7 (a.py:1)"}, "error: ValueError"),
        (
            {"message": "worker died (9) in step 12"},
            "error: worker died (#) in step #",
        ),
        ({"message": ""}, "error: no reason given"),
        ({"message": "x" * 500}, "error: " + "x" * 60),
    ],
)
def test_ending_is_named(fields: dict[str, object], words: str) -> None:
    status = "error" if "message" in fields else "ok"
    assert ending(make_row(status=status, **fields)) == words


def test_alike_endings_are_counted_together_success_first() -> None:
    rows = [
        make_row(complete=0.0),
        make_row(complete=0.0),
        make_row(success=True, complete=1.0),
        make_row(status="error", message="act, step 1: OSError: a"),
        make_row(status="error", message="act, step 2: OSError: b"),
        make_row(status="error", message="act, step 3: OSError: c"),
    ]
    assert count_endings(rows) == [
        ("success", 1),
        ("error: OSError", 3),
        ("out of steps, 0 % complete", 2),
    ]
    assert count_endings([]) == []
