"""``icd-bench collect``."""

import json
from pathlib import Path

import pytest

from benchmarks import collect_command
from icd_envs.demonstrations import Demonstrations
from icd_envs.demonstrations.header import read_header
from tests.bench.making import icd_bench
from tests.envs.making import CABLE

COLLECT = ("collect", "--env", CABLE, "--episodes", 2, "--steps", 5)


def test_collect_prints_what_there_is_and_goes_on(tmp_path: Path) -> None:
    out = tmp_path / "späce d"
    collected = icd_bench(*COLLECT, "--out", out, "--json")
    assert collected.exit_code == 0, collected.stderr
    values = json.loads(collected.stdout)
    demonstrations = Demonstrations(out)
    assert values["episodes"] == len(demonstrations) == 2
    assert values["steps"] == demonstrations.lengths.sum() == 10
    assert (values["success"], values["diverged"]) == (0.0, 0)
    assert "2/2 episodes" in collected.stderr
    again = icd_bench(*COLLECT, "--out", out)
    assert again.exit_code == 0
    assert "episodes" in again.stdout
    assert icd_bench(*COLLECT, "--out", out, "--no-resume").exit_code == 2
    other = icd_bench(*COLLECT, "--out", out, "--seed", 1)
    assert (other.exit_code, other.stdout) == (3, "")


def test_options_of_the_task_are_recorded_and_used() -> None:
    wanted = ["num_fixtures=3", "goals=contact"]
    header = collect_command.make_header(CABLE, 3, seed=0, steps=None, options=wanted)
    assert header.options == {"num_fixtures": 3, "goals": "contact"}
    assert header.steps == 500


def test_longest_episode_is_the_budget_unless_it_is_given() -> None:
    assert collect_command.make_header(CABLE, 3, seed=0, steps=None).steps == 300
    assert collect_command.make_header(CABLE, 3, seed=0, steps=200).steps == 200


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--env", "ICDCableRoutin-v0", "--episodes", "1"], "did you mean 'ICDCableRouting-v0'"),
        (["--env", CABLE, "--episodes", "0"], "--episodes"),
        (["--env", CABLE, "--episodes", "1", "--steps", "301"], "steps must be in [1, 300]"),
        (["--env", CABLE, "--episodes", "1", "--minari", "no id"], "is not valid"),
        (["--env", CABLE, "--episodes", "1", "--option", "goals"], "must be name=value"),
        (["--env", CABLE, "--episodes", "1", "--option", "goal=contact"], "did you mean 'goals'"),
        (["--env", CABLE, "--episodes", "1", "--option", "goals=contacts"], "mean 'contact'"),
        (["--env", CABLE, "--episodes", "1", "--option", "num_fixtures=5"], "[1, 4], got 5"),
    ],
)
def test_usage_errors_exit_2_before_anything_is_recorded(
    tmp_path: Path, arguments: list[str], message: str
) -> None:
    refused = icd_bench("collect", *arguments, "--out", tmp_path / "out")
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert message in " ".join(refused.stderr.split())
    assert list(tmp_path.iterdir()) == []


def test_minari_dataset_is_made_after_the_last_episode(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    arguments = (*COLLECT, "--out", tmp_path / "out", "--minari", "icd/cable-v0", "--json")
    collected = icd_bench(*arguments)
    assert collected.exit_code == 0, collected.stderr
    values = json.loads(collected.stdout)
    assert values["minari_episodes"] + values["minari_left_out"] == 2
    assert Path(values["minari"]) == tmp_path / "minari" / "icd" / "cable-v0"
    assert read_header(tmp_path / "out").episodes == 2
    again = icd_bench(*arguments)
    assert again.exit_code == 2
    assert "exists already" in again.stderr
