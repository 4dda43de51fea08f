"""The command line: exit codes, streams, imports."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from click.testing import Result

from benchmarks import gates, registry
from benchmarks.cli import main
from benchmarks.manifest import FILE_NAME as MANIFEST_NAME
from benchmarks.results import ROWS_NAME
from tests.bench import toy
from tests.bench.making import icd_bench
from tests.bench.test_gates import Gate


def run(out: Path, agent: type, *more: object) -> Result:
    return icd_bench(
        "run", "--agent", toy.spec(agent), "--env", toy.ENV, "--out", out, "--episodes", 3, *more
    )


def test_importing_the_command_line_imports_nothing_heavy() -> None:
    heavy = ["torch", "mujoco", "gymnasium", "scipy", "numpy", "icd_envs", "rich.progress"]
    code = f"import sys, benchmarks.cli; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def commands(group: object, *words: str) -> Iterator[tuple[str, ...]]:
    """Words of every command and of every group of commands."""
    yield words
    for name, command in getattr(group, "commands", {}).items():
        yield from commands(command, *words, name)


COMMANDS = sorted(commands(typer.main.get_command(main)))


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_says_what_it_is_for_and_its_group_names_it(
    words: tuple[str, ...],
) -> None:
    shown = icd_bench(*words, "--help")
    assert shown.exit_code == 0
    usage, _, text = (line.strip() for line in shown.stdout.strip().splitlines()[:3])
    assert usage.startswith("Usage: ")
    assert text[:1].isupper()
    if words:
        assert f" {words[-1]} " in icd_bench(*words[:-1], "--help").stdout


def test_the_documented_commands_are_there() -> None:
    told = {"run", "report", "reproduce", "gates", "collect", "watch", "perf", "check-agent"}
    assert told | {"list", "export-scene", "train", "diagnose", "render"} == {
        words[0] for words in COMMANDS if words
    }


def test_list_names_agents_envs_suites_and_gates() -> None:
    listed = icd_bench("list")
    assert listed.exit_code == 0, listed.stderr
    for name in (*registry.AGENTS, "ICDCableRouting-v0", "smoke", "quick", "noisy_divergences"):
        assert name in listed.stdout


def test_run_prints_a_table_and_report_repeats_it(tmp_path: Path) -> None:
    ran = run(tmp_path / "out", toy.Planner)
    assert ran.exit_code == 0, ran.stderr
    assert "3/3" in ran.stdout
    assert "privileged" in ran.stdout
    assert str(tmp_path / "out") in ran.stderr
    assert "3/3 episodes, success 3/3" in ran.stderr
    reported = icd_bench("report", tmp_path / "out")
    assert reported.exit_code == 0
    assert reported.stdout == ran.stdout


@pytest.mark.parametrize("workers", [1, 2])
def test_json_is_alone_on_stdout(tmp_path: Path, workers: int) -> None:
    command = ["run", "--agent", toy.spec(toy.Chatty), "--env", toy.ENV, "--episodes", "3"]
    more = ["--workers", str(workers), "--out", str(tmp_path / "out"), "--json"]
    ran = subprocess.run(
        [sys.executable, "-m", "benchmarks", *command, *more],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "thinking" in ran.stderr
    (record,) = json.loads(ran.stdout)
    assert (record["episodes"], record["errors"], record["success"]) == (3, 0, 1.0)
    assert json.loads(icd_bench("report", tmp_path / "out", "--json").stdout) == [record]


def test_errored_episodes_exit_1(tmp_path: Path) -> None:
    ran = run(tmp_path / "out", toy.Nan, "--json")
    assert ran.exit_code == 1
    (record,) = json.loads(ran.stdout)
    assert (record["errors"], record["success"], record["success_ci"]) == (3, None, None)


def test_errors_are_run_again(tmp_path: Path) -> None:
    assert run(tmp_path / "out", toy.Nan).exit_code == 1
    again = run(tmp_path / "out", toy.Nan, "--retry-errors")
    assert (again.exit_code, "3 with an error run again" in again.stdout) == (1, True)
    told = icd_bench("report", tmp_path / "out", "--json")
    assert "its runs differ: 3 with an error run again" in told.stderr
    assert json.loads(told.stdout)[0]["errors"] == 3


def test_agent_that_ends_its_process_is_an_error_even_with_one_worker(tmp_path: Path) -> None:
    ran = run(tmp_path / "out", toy.Killer, "--json", "--seed", 8)
    assert ran.exit_code == 1
    (record,) = json.loads(ran.stdout)
    assert (record["episodes"], record["success"]) == (3, 1.0)
    assert 0 < record["errors"] < 3


def test_fresh_folder_without_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        ran = icd_bench("run", "--agent", toy.spec(toy.Straight), "--env", toy.ENV, "--episodes", 1)
        assert ran.exit_code == 0, ran.stderr
    assert len(list(tmp_path.glob(f"runs/*/{ROWS_NAME}"))) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "--agent", "pc-mpi", "--env", toy.ENV], "did you mean 'pc-mppi'"),
        (["run", "--agent", "random", "--env", "ICDCableRoutin-v0"], "'ICDCableRouting-v0'"),
        (["run", "--agent", "random", "--suite", "quik"], "did you mean 'quick'"),
        (["run", "--agent", toy.spec("Straight"), "--env", toy.ENV, "--resume"], "needs --out"),
        (["run", "--agent", "random", "--episodes", "0"], "--episodes"),
        (["run", "--agent", "random", "--env", "CartPole-v1"], "making CartPole-v1: TypeError"),
        (["run"], "--agent"),
        (["report", "nowhere"], "manifest.json is missing"),
        (["gates", "--env", "CartPole-v1"], "no gates"),
        (["gates", "--env", "ICDCableRouting-v0", "--only", "nothing"], "unknown gate"),
        (["no-such-command"], "no-such-command"),
    ],
)
def test_usage_errors_exit_2_in_one_line(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    refused = icd_bench(*arguments)
    assert refused.exit_code == 2
    assert message in " ".join(refused.stderr.split())
    assert refused.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_results_are_kept_without_resume_and_incompatible_resume_exits_3(tmp_path: Path) -> None:
    assert run(tmp_path / "out", toy.Straight).exit_code == 0
    before = (tmp_path / "out" / ROWS_NAME).read_bytes()
    again = run(tmp_path / "out", toy.Straight)
    assert (again.exit_code, again.stdout) == (2, "")
    assert "has results already" in again.stderr
    other = run(tmp_path / "out", toy.Straight, "--seed", 1, "--resume")
    assert (other.exit_code, other.stdout) == (3, "")
    assert "base seed: 0 there, 1 now" in other.stderr
    changed = ("--resume", "--act-seconds", 9, "--episodes", 4)
    assert run(tmp_path / "out", toy.Straight, *changed).exit_code == 3
    assert (tmp_path / "out" / ROWS_NAME).read_bytes() == before
    mixed = run(tmp_path / "out", toy.Straight, *changed, "--allow-mixed", "--json")
    assert mixed.exit_code == 0, mixed.stderr
    assert json.loads(mixed.stdout)[0]["episodes"] == 4
    assert "act_seconds" in json.loads((tmp_path / "out" / MANIFEST_NAME).read_text())["mixed"][0]


def test_gates_print_json_and_exit_by_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = gates.AgentRuns(toy.spec(toy.Straight), 2)
    good = Gate("good", source, "success", ">=", 0.9)
    bad = Gate("bad", source, "complete", "in", (0.0, 0.5))
    monkeypatch.setitem(gates.GATES, toy.ENV, (good, bad))
    command = ("gates", "--env", toy.ENV, "--out", tmp_path)
    judged = icd_bench(*command, "--json")
    assert judged.exit_code == 1
    assert json.loads(judged.stdout) == {
        "good": {"value": 1.0, "bound": 0.9, "n": 2, "ok": True},
        "bad": {"value": 1.0, "bound": [0.0, 0.5], "n": 2, "ok": False},
    }
    table = icd_bench(*command, "--only", "good")
    assert table.exit_code == 0
    assert ">= 0.9" in table.stdout
    assert icd_bench(*command, "--no-resume").exit_code == 2


def test_perf_prints_what_was_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    from types import ModuleType

    module = ModuleType("benchmarks.perf.report")
    module.measure = lambda repeats: {"physics_us": 100.0 * repeats, "cpu": "toy"}
    monkeypatch.setitem(sys.modules, "benchmarks.perf.report", module)
    printed = icd_bench("perf", "--repeats", 2, "--json")
    assert json.loads(printed.stdout) == {"physics_us": 200.0, "cpu": "toy"}
    assert "200" in icd_bench("perf", "--repeats", 2).stdout
