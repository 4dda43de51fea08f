"""Options of the command line reach what they are for."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from benchmarks import gates, report_command, runner, suites, train_field, train_policy
from benchmarks.conditions import Condition, TaskSpec
from benchmarks.executors import InProcess, Local
from benchmarks.manifest import read_manifest
from benchmarks.plan import plan_suite
from benchmarks.results import read_rows
from benchmarks.suites import CABLE, NOTEBOOK, Suite, find_suite
from benchmarks.train_field import Scales, scales_of
from benchmarks.worker import MATH_THREADS, maths_threads
from icd_envs.errors import InvalidOptionError
from tests.bench import toy
from tests.bench.making import icd_bench, in_order

Arguments = dict[str, Any]
Given = Callable[..., Arguments]
FAR = "this is as far as it goes"


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> Given:
    """What a function is given by a command, which goes no further."""

    def given(module: object, name: str, *command: object) -> Arguments:
        kept: Arguments = {}
        signature = inspect.signature(getattr(module, name))

        def keep(*args: object, **options: object) -> None:
            kept.update(signature.bind(*args, **options).arguments)
            raise InvalidOptionError(FAR)

        monkeypatch.setattr(module, name, keep)
        ended = icd_bench(*command)
        assert FAR in ended.stderr, ended.stderr
        return kept

    return given


@pytest.fixture
def one_maths_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever a run in this process settles for is forgotten after the test."""
    monkeypatch.setenv(MATH_THREADS, maths_threads())


RUN = ("run", "--agent", "random", "--out", "nowhere")


@pytest.mark.parametrize(
    ("options", "tasks"),
    [
        (("--condition", "contact goals"), {(CABLE, "contact goals")}),
        (
            ("--condition", "rope cable", "--condition", "default"),
            {(CABLE, "rope cable"), (CABLE, "default"), (NOTEBOOK, "default")},
        ),
        (("--condition", "default", "--env", NOTEBOOK), {(NOTEBOOK, "default")}),
    ],
)
def test_run_is_of_the_conditions_that_are_named(
    given: Given, options: tuple[str, ...], tasks: set[tuple[str, str]]
) -> None:
    told = given(runner, "run", *RUN, "--suite", "robust", *options)
    assert {task.key for task in told["plan"].tasks} == tasks
    assert told["plan"].suite == ""


def test_run_of_a_suite_is_the_whole_suite(given: Given) -> None:
    told = given(runner, "run", *RUN, "--suite", "contact")
    assert told["plan"] == plan_suite(find_suite("contact"), ["random"])


@pytest.mark.parametrize(
    ("options", "executor", "threads"),
    [
        (("--workers", "3", "--threads", "5"), Local(3, 5), 5),
        (("--threads", "7"), Local(1, 7), 7),
        (("--workers", "0", "--threads", "2"), InProcess(2), 2),
    ],
)
def test_run_is_done_by_the_workers_and_threads_that_are_asked_for(
    given: Given,
    one_maths_thread: None,
    options: tuple[str, ...],
    executor: object,
    threads: int,
) -> None:
    told = given(runner, "run", *RUN, *options)
    assert told["executor"] == executor
    assert told["work"].do.keywords["settings"].threads == threads


def test_run_gives_an_episode_its_seconds(given: Given) -> None:
    told = given(runner, "run", *RUN, "--episode-seconds", "77", "--act-seconds", "7")
    assert told["work"].seconds == told["settings"]["episode_seconds"] == 77.0
    assert told["work"].do.keywords["settings"].act_seconds == told["settings"]["act_seconds"] == 7


def test_gates_are_run_by_the_workers_and_threads_that_are_asked_for(given: Given) -> None:
    command = ("gates", "--env", CABLE, "--workers", 2, "--threads", 9)
    told = given(gates, "run_gates", *command)
    assert told["executor"] == Local(2, 9)


@pytest.mark.parametrize(
    ("options", "videos", "megabytes"),
    [
        ((), "all", 25.0),
        (("--videos", "failures"), "failures", 25.0),
        (("--videos", "first", "--video-megabytes", "1.5"), "first", 1.5),
    ],
)
def test_report_shows_the_videos_that_are_asked_for(
    given: Given, options: tuple[str, ...], videos: str, megabytes: float
) -> None:
    told = given(report_command, "report", "report", "somewhere", *options)
    assert (told["videos"], told["megabytes"]) == (videos, megabytes)
    assert told["folders"] == [Path("somewhere")]


@pytest.mark.parametrize(
    ("option", "name", "value"),
    [
        ("--length-scale", "length", 0.7),
        ("--outlook-scale", "outlook", 0.3),
        ("--near-spread", "near", 0.09),
        ("--anchors", "anchors", 77),
        ("--steps", "steps", 5),
    ],
)
@pytest.mark.parametrize("env_id", [CABLE, NOTEBOOK])
def test_a_scale_of_the_field_is_the_shipped_one_unless_it_is_given(
    given: Given, env_id: str, option: str, name: str, value: float
) -> None:
    command = ("train", "field", "--env", env_id, "--data", "data", "--out", "out", option, value)
    told = given(train_field, "train", *command)
    usual: Scales = scales_of(env_id, "local")
    assert getattr(usual, name) != value
    assert told["scales"] == usual._replace(**{name: value})


@pytest.mark.parametrize("name", ["diffusion-policy", "dp3"])
@pytest.mark.parametrize(
    ("options", "solved_only"),
    [((), True), (("--solved-only",), True), (("--all-episodes",), False)],
)
def test_policies_imitate_the_episodes_that_are_asked_for(
    given: Given, name: str, options: tuple[str, ...], solved_only: bool
) -> None:
    command = ("train", name, "--env", CABLE, "--data", "data", "--out", "out", *options)
    told = given(train_policy, "train", *command)
    assert (told["name"], told["solved_only"]) == (name, solved_only)


@pytest.fixture
def toy_suite(monkeypatch: pytest.MonkeyPatch) -> None:
    """A suite of the toy task as it is and with noise."""
    tasks = (TaskSpec(toy.ENV), TaskSpec(toy.ENV, Condition("noisy", action_noise=0.7)))
    suite = Suite("toys", version=3, tasks=tasks, episodes=2)
    monkeypatch.setattr(suites, "SUITES", MappingProxyType({"toys": suite}))


def test_a_suite_is_run_whole_or_under_one_condition(
    toy_suite: None, one_maths_thread: None, tmp_path: Path
) -> None:
    command = ("run", "--agent", toy.spec(toy.Straight), "--suite", "toys", "--workers", 0)
    for out, options in (("whole", ()), ("part", ("--condition", "noisy"))):
        ran = icd_bench(*command, "--out", tmp_path / out, *options)
        assert ran.exit_code == 0, ran.stderr
    whole, part = (in_order(read_rows(tmp_path / out)) for out in ("whole", "part"))
    assert [(row.condition, row.index) for row in whole] == [
        ("default", 0), ("default", 1), ("noisy", 0), ("noisy", 1),
    ]  # fmt: skip
    assert part == whole[2:]
    assert [row.seed for row in part] == [row.seed for row in whole[:2]]
    assert [row.steps for row in part] != [row.steps for row in whole[:2]]
    assert [read_manifest(tmp_path / out).suite for out in ("whole", "part")] == ["toys v3", ""]


def test_rows_of_a_run_in_this_process_are_those_of_a_worker(
    one_maths_thread: None, tmp_path: Path
) -> None:
    agents = ("--agent", toy.spec(toy.Drunk), "--agent", toy.spec(toy.Gambler))
    command = ("run", *agents, "--agent", toy.spec(toy.Raiser), "--env", toy.ENV, "--episodes", 4)
    for workers in (0, 1):
        ran = icd_bench(*command, "--workers", workers, "--out", tmp_path / str(workers))
        assert ran.exit_code == 1, ran.stderr  # the raiser's
    here, there = (in_order(read_rows(tmp_path / str(workers))) for workers in (0, 1))
    assert here == there
    assert len({row.steps for row in here}) > 2
