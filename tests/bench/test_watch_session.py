"""What a session does, step by step."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.attempt import Attempt, Settings
from benchmarks.episode import play
from benchmarks.plan import Job
from benchmarks.pulse import Pulse
from benchmarks.registry import Offer, make_agent
from benchmarks.suites import episode_seed
from benchmarks.watch.session import Session
from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError
from tests.bench import toy
from tests.bench.watched import CABLE, Dreamer, Faller, Liar, Sleepyhead, spec
from tests.envs.making import digest, make


@pytest.fixture
def sessions() -> Iterator[list[Session]]:
    """Closed afterwards."""
    opened: list[Session] = []
    yield opened
    for session in opened:
        session.close()


def open_session(sessions: list[Session], agent: str, env: str = CABLE, seed: int = 0) -> Session:
    sessions.append(Session(agent, env, seed=seed))
    return sessions[-1]


def test_episodes_are_those_of_the_benchmark(sessions: list[Session]) -> None:
    session = open_session(sessions, "random", seed=7)
    moment = session.begin(2)
    seed = episode_seed(7, CABLE, 2)
    assert (moment.episode, moment.seed, moment.step, moment.budget) == (2, seed, 0, 300)
    while not moment.end:
        moment = session.advance()
    assert (moment.step, moment.end) == (300, "out of time")
    row = play(Attempt(Job("random", CABLE, 2, seed)), Pulse(), Settings()).row
    found = (moment.success, moment.complete_rate, moment.step)
    assert (row.success, row.complete, row.steps) == found
    assert session.advance() is moment  # nothing happens after the end


def test_options_are_those_of_the_task(sessions: list[Session]) -> None:
    session = Session("expert", CABLE, options=(("goals", "contact"),))
    sessions.append(session)
    moment = session.begin(3)
    reached = []
    while not moment.end:
        moment = session.advance()
        reached.append(moment.success)
    # Such a goal must be kept, so that success does not end the episode.
    assert (moment.end, moment.step, moment.success) == ("out of time", 300, True)
    assert reached.index(True) < 299


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_expert_is_watched_to_success_in_every_environment(
    sessions: list[Session], env_id: str
) -> None:
    session = open_session(sessions, "expert", env_id)
    moment = session.begin(0)
    while not moment.end:
        moment = session.advance()
    assert (moment.end, moment.success, moment.complete_rate) == ("success", True, 1.0)
    assert moment.plan is None
    assert moment.future is None
    again = session.begin(1)
    assert (again.step, again.end) == (0, "")
    assert session.errors == 0


def test_plan_and_where_it_leads_are_shown(sessions: list[Session]) -> None:
    session = open_session(sessions, spec(Dreamer))
    assert session.begin(0).plan is None
    first = session.advance()
    assert first.plan is not None
    assert first.future is not None
    assert first.plan.status == "dreaming"
    later = first
    np.testing.assert_array_equal(first.future.path[0], first.observation["observation"][:3])
    for _ in range(9):
        later = session.advance()
    # The plan did not change: what was foreseen came true, to the bit.
    np.testing.assert_array_equal(first.future.path[-1], later.observation["observation"][:3])
    np.testing.assert_array_equal(first.future.end, later.observation["achieved_goal"])


def test_agent_that_is_watched_does_what_it_does_alone(sessions: list[Session]) -> None:
    watched = open_session(sessions, "pc-mppi")
    seed = watched.begin(0).seed
    moments = [watched.advance() for _ in range(2)]
    assert moments[1].future is not None
    env, agent = make(CABLE), make_agent("pc-mppi", Offer(CABLE))
    observation, _ = env.reset(seed=seed)
    agent.reset(env.episode(simulator=True), seed)
    for moment in moments:
        observation = env.step(agent.act(observation))[0]
        assert digest([observation]) == digest([moment.observation])
    env.close()


@pytest.mark.parametrize(
    ("agent", "message", "steps"),
    [
        (Faller, "ZeroDivisionError: <script>", 2),
        (Liar, "plan_view() returned str: return icd_envs.api.PlanView", 0),
        (Sleepyhead, "SystemExit", 0),
    ],
)
def test_error_of_an_agent_ends_the_episode_and_the_next_one_begins(
    sessions: list[Session], agent: type, message: str, steps: int
) -> None:
    session = open_session(sessions, spec(agent))
    for errors in (1, 2):
        moment = session.begin(0)
        for _ in range(4):
            moment = session.advance()
        assert moment.end.startswith("error: ")
        assert message in moment.end
        assert moment.step == steps
        assert session.errors == errors


def test_other_environments_are_refused() -> None:
    with pytest.raises(InvalidOptionError, match="ToyEnv: only this project's"):
        Session("random", toy.ENV)
