"""Seeds and plans."""

import numpy as np
import pytest

from benchmarks.plan import Plan
from benchmarks.suites import SUITES, episode_seed, find_suite
from icd_envs.errors import InvalidOptionError


def test_seed_follows_the_documented_law() -> None:
    crc_of_toy = 0x44A1DFA7  # zlib.crc32(b"Toy-v0")
    expected = int(np.random.SeedSequence([7, crc_of_toy, 3]).generate_state(1)[0]) >> 1
    assert episode_seed(7, "Toy-v0", 3) == expected
    assert episode_seed(7, "tests.bench.toy:Toy-v0", 3) == expected


def test_seeds_differ_and_are_valid() -> None:
    seeds = {episode_seed(b, e, i) for b in range(3) for e in ("A-v0", "B-v0") for i in range(50)}
    assert len(seeds) == 300
    assert all(0 <= seed < 2**31 for seed in seeds)


def test_seed_is_the_same_for_every_agent_and_plan_size() -> None:
    small = Plan(agents=("a",), envs=("E-v0",), episodes=2, seed=5)
    large = Plan(agents=("b", "a"), envs=("F-v0", "E-v0"), episodes=4, seed=5)
    seeds = {job.key: job.seed for job in large.jobs()}
    assert len(seeds) == 16
    assert all(seeds[job.key] == job.seed for job in small.jobs())
    assert seeds["a", "E-v0", 1] == seeds["b", "E-v0", 1] != seeds["a", "F-v0", 1]


def test_agents_take_turns() -> None:
    jobs = Plan(agents=("a", "b"), envs=("E-v0",), episodes=2).jobs()
    assert [(job.agent, job.index) for job in jobs] == [("a", 0), ("b", 0), ("a", 1), ("b", 1)]


@pytest.mark.parametrize(
    ("plan", "extends"),
    [
        (Plan(("a",), ("E",), 2), True),
        (Plan(("b", "a"), ("E", "F"), 3), True),
        (Plan(("a",), ("E",), 1), False),
        (Plan(("b",), ("E",), 2), False),
        (Plan(("a",), ("F",), 2), False),
        (Plan(("a",), ("E",), 2, seed=1), False),
    ],
)
def test_plan_extends_only_supersets(plan: Plan, extends: bool) -> None:
    assert plan.extends(Plan(("a",), ("E",), 2)) is extends


@pytest.mark.parametrize(
    "fields",
    [
        {"episodes": 0},
        {"seed": -1},
        {"agents": ("a", "a")},
        {"envs": ()},
    ],
)
def test_plan_refuses_nonsense(fields: dict[str, object]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(fields))):
        Plan(**{"agents": ("a",), "envs": ("E",), "episodes": 1, **fields})


def test_suites_are_versioned_and_found_by_name() -> None:
    assert find_suite("smoke").episodes == 1
    assert find_suite("quick").episodes == 10
    assert all(suite.version >= 1 and suite.env_ids for suite in SUITES.values())
    with pytest.raises(InvalidOptionError, match="did you mean 'quick'"):
        find_suite("quik")
