"""What the README shows must run as it stands there."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str, marker: str) -> str:
    found = [
        text for text in re.findall(rf"```{language}\n(.*?)```", README, re.S) if marker in text
    ]
    assert len(found) == 1, f"expected one {language} block with {marker!r}"
    return found[0]


def test_readme_options_example_runs() -> None:
    code = block("python", "num_fixtures=3")
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=240
    )
    assert result.returncode == 0, result.stderr


def test_readme_environment_example_runs() -> None:
    code = block("python", "action_space.sample")
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == ["False", "0.0", "(200,", "3)"]


def test_readme_icd_example_runs() -> None:
    code = block("python", "ICDAgent")
    long, short = "while not done:", "for _ in range(3):"
    assert code.count(long) == 1
    result = subprocess.run(
        [sys.executable, "-c", code.replace(long, short)],
        capture_output=True, text=True, check=False, timeout=240,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == ["False", "0.0"]


def test_readme_agent_example_gets_a_row_in_the_table(tmp_path: Path) -> None:
    (tmp_path / "my_agent.py").write_text(block("python", "my_agent.py"), encoding="utf-8")
    command = re.search(r"icd-bench (run --agent my_agent:Pull .*) --episodes 20", README)
    assert command is not None
    arguments = [*command[1].split(), "--episodes", "2", "--out", "mine", "--json"]
    result = subprocess.run(
        [sys.executable, "-m", "benchmarks", *arguments],
        capture_output=True, text=True, check=False, timeout=240, cwd=tmp_path,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    (row,) = json.loads(result.stdout)
    assert (row["agent"], row["episodes"], row["errors"]) == ("my_agent:Pull", 2, 0)
