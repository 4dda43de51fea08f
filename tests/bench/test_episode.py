"""One episode, well or badly behaved."""

import re

import numpy as np
import pytest

from tests.bench import toy
from tests.bench.making import play


def test_finished_episode_is_reported_as_the_environment_saw_it() -> None:
    row = play(toy.Straight, seed=4)
    goal = np.random.Generator(np.random.PCG64(4)).uniform(-2.0, 2.0, 3)
    steps = int(np.ceil((np.abs(goal).max() - 0.2) / 0.5))
    assert (row.status, row.success, row.complete, row.message) == ("ok", True, 1.0, "")
    assert row.steps in (steps, steps + 1)
    assert row.return_ == -row.steps
    assert row.seconds >= row.act_seconds * row.steps > 0.0


def test_truncated_episode_is_a_failure_not_an_error() -> None:
    rows = [play(toy.Drunk, seed=seed) for seed in range(8)]
    failed = [row for row in rows if not row.success]
    assert failed
    assert all(row.status == "ok" and row.steps == toy.MAX_STEPS for row in failed)


def test_episode_repeats_bit_for_bit_after_any_history() -> None:
    first = play(toy.Drunk, seed=3)
    play(toy.Drunk, seed=5)
    play(toy.Raiser, seed=5)
    assert play(toy.Drunk, seed=3).without_times() == first.without_times()


def test_agent_cannot_change_the_episode_through_its_observation() -> None:
    honest, vandal = play(toy.Straight), play(toy.Vandal)
    assert (vandal.steps, vandal.return_, vandal.success) == (
        honest.steps,
        honest.return_,
        honest.success,
    )


def test_only_agents_that_ask_get_the_simulator_and_are_marked() -> None:
    assert play(toy.Planner).status == "ok"
    assert play(toy.Planner).privileged
    assert not play(toy.Straight).privileged


@pytest.mark.parametrize(
    ("agent", "env", "reason"),
    [
        (toy.Raiser, toy.ENV, r"act, step 0: ZeroDivisionError: odd seeds.*\(toy.py:\d+\)"),
        (toy.Quitter, toy.ENV, "act, step 0: SystemExit: 4"),
        (toy.Nan, toy.ENV, "env.step, step 0: InvalidActionError.*nan"),
        (toy.Flat, toy.ENV, r"env.step, step 0: InvalidActionError: action must be \(3,\)"),
        (toy.Unready, toy.ENV, "making the agent, step 0: InvalidOptionError"),
        (toy.Straight, toy.UNSOLVABLE, "resetting the environment.*SceneGenerationError.*seed 3"),
        (toy.Straight, toy.CRASHING, "env.step, step 0: RuntimeError: physics on fire"),
        (toy.Straight, toy.NAN_RATE, "complete must be a finite float, got nan"),
    ],
)
def test_whatever_goes_wrong_is_an_error_row(agent: type, env: str, reason: str) -> None:
    row = play(agent, env, seed=3)
    assert (row.status, row.success, row.complete) == ("error", False, 0.0)
    assert re.search(reason, row.message), row.message
    assert "\n" not in row.message


def test_agent_that_raised_is_made_anew() -> None:
    assert play(toy.Raiser, seed=3).status == "error"
    assert play(toy.Raiser, seed=2).status == "ok"
