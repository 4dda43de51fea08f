"""Seeds and plans."""

from typing import Any

import numpy as np
import pytest

from benchmarks.conditions import Condition, TaskSpec, make_env
from benchmarks.manifest import config_hash
from benchmarks.plan import Plan, plan_suite
from benchmarks.suites import (
    CABLE,
    CONTACT_GOALS,
    SUITES,
    agent_seed,
    episode_seed,
    find_suite,
)
from icd_envs.errors import InvalidOptionError
from icd_envs.registration import ENV_IDS

PROMISED = {
    "smoke": (2, "c1ba94dd2214712e07218074cf54d0e9bd506c6012a265cba77a819119cc5770"),
    "quick": (2, "ab9351f94f79da3a24c356df98e70d037a0aa9f066afb82acb97df6c4569f32f"),
    "paper": (1, "bf07595846e88d0f2d3fc8c57ed86b8fbf94f3c3ec851300603fd6fa69858010"),
    "full": (1, "f577a703f6f1189b6ea212403d034c6b623aea33e59efc476c6a69478ed0ac40"),
    "robust": (3, "e44a16e6ceadd48f9901449fbd590d976ae847c1a6f01d09710e99edb39b1004"),
    "contact": (2, "dede3b44923d4c5065482214732d68f21e0a54b7087630305c0a8468f0b90826"),
    "validation": (1, "f70ae4c43666ae28801d7fa9c7bb3c89a91f2aba4601cda313f0b903d1b51921"),
}
"""Version of every suite, and the sha256 of its plan for one agent called ``a``."""


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
    small = Plan(agents=("a",), tasks=(TaskSpec("E-v0"),), episodes=2, seed=5)
    large = Plan(agents=("b", "a"), tasks=(TaskSpec("F-v0"), TaskSpec("E-v0")), episodes=4, seed=5)
    seeds = {job.key: job.seed for job in large.jobs()}
    assert len(seeds) == 16
    assert all(seeds[job.key] == job.seed for job in small.jobs())
    mine = {(agent, env): seeds[agent, env, "default", 1, 0] for agent, env, *_ in seeds}
    assert mine["a", "E-v0"] == mine["b", "E-v0"] != mine["a", "F-v0"]


def test_agents_take_turns() -> None:
    jobs = Plan(agents=("a", "b"), tasks=(TaskSpec("E-v0"),), episodes=2).jobs()
    assert [(job.agent, job.index) for job in jobs] == [("a", 0), ("b", 0), ("a", 1), ("b", 1)]


@pytest.mark.parametrize(
    ("plan", "extends"),
    [
        (Plan(("a",), (TaskSpec("E"),), 2), True),
        (Plan(("b", "a"), (TaskSpec("E"), TaskSpec("F")), 3), True),
        (Plan(("a",), (TaskSpec("E"),), 1), False),
        (Plan(("b",), (TaskSpec("E"),), 2), False),
        (Plan(("a",), (TaskSpec("F"),), 2), False),
        (Plan(("a",), (TaskSpec("E"),), 2, seed=1), False),
    ],
)
def test_plan_extends_only_supersets(plan: Plan, extends: bool) -> None:
    assert plan.extends(Plan(("a",), (TaskSpec("E"),), 2)) is extends


@pytest.mark.parametrize(
    "fields",
    [
        {"episodes": 0},
        {"seed": -1},
        {"agents": ("a", "a")},
        {"tasks": ()},
    ],
)
def test_plan_refuses_nonsense(fields: dict[str, object]) -> None:
    with pytest.raises(InvalidOptionError, match=next(iter(fields))):
        Plan(**{"agents": ("a",), "tasks": (TaskSpec("E"),), "episodes": 1, **fields})


def test_a_suite_changes_only_with_its_version() -> None:
    assert {
        name: (suite.version, config_hash(plan_suite(suite, ["a"])).removeprefix("sha256:"))
        for name, suite in SUITES.items()
    } == PROMISED


def test_suites_are_found_by_name() -> None:
    assert find_suite("smoke").episodes == 1
    assert find_suite("paper").description == "3 tasks x 10 cases x 2 seeds"
    with pytest.raises(InvalidOptionError, match="did you mean 'quick'"):
        find_suite("quik")


def test_repeats_meet_the_same_scenes_with_another_seed_of_the_agent() -> None:
    once = Plan(("a",), (TaskSpec("E-v0"),), 3)
    jobs = Plan(("a",), (TaskSpec("E-v0"),), 3, repeats=2).jobs()
    assert jobs[:3] == once.jobs()
    assert [job.seed for job in jobs[3:]] == [job.seed for job in jobs[:3]]
    assert all(job.agent_seed == job.seed for job in jobs[:3])
    assert len({job.agent_seed for job in jobs}) == 6


@pytest.mark.parametrize(("repeat", "seed"), [(0, 123456789), (1, 1669894314), (2, 1597041585)])
def test_agents_seed_follows_the_documented_law(repeat: int, seed: int) -> None:
    assert agent_seed(123456789, repeat) == seed


def test_conditions_share_scenes() -> None:
    noisy = TaskSpec("E-v0", Condition("noisy", action_noise=0.1))
    plain, shaken = Plan(("a",), (TaskSpec("E-v0"), noisy), 1).jobs()
    assert plain.seed == shaken.seed
    assert plain.key != shaken.key


def test_parts_of_a_suite_lose_its_name() -> None:
    suite = find_suite("quick")
    assert plan_suite(suite, ["a", "a"]).suite == suite.title
    assert plan_suite(suite, ["a"], episodes=suite.episodes).suite == suite.title
    part = plan_suite(suite, ["a"], envs=[suite.tasks[1].env, "Own-v0"], episodes=2)
    assert (part.suite, part.tasks) == ("", (suite.tasks[1], TaskSpec("Own-v0")))


def test_conditions_of_a_suite_can_be_chosen() -> None:
    suite = find_suite("robust")
    part = plan_suite(suite, ["a"], envs=[CABLE], conditions=["contact goals"])
    assert part.tasks == (TaskSpec(CABLE, CONTACT_GOALS),)
    assert part.suite == ""
    two = plan_suite(suite, ["a"], conditions=["default", "rope cable"])
    assert [task.condition.name for task in two.tasks] == ["default", "rope cable", "default"]
    with pytest.raises(InvalidOptionError, match="did you mean 'contact goals'"):
        plan_suite(suite, ["a"], conditions=["contact goal"])
    with pytest.raises(InvalidOptionError, match="rope cable"):
        plan_suite(find_suite("quick"), ["a"], conditions=["rope cable"])


def test_validation_shares_no_scene_with_tests_or_demonstrations() -> None:
    suite = find_suite("validation")
    plan = plan_suite(suite, ["a"])
    assert plan.suite == suite.title
    for task in plan.tasks:
        env: Any = make_env(task)
        assert env.unwrapped.split == "train"
        env.close()
    # Demonstrations take the seeds of base seed 0, more of them than anyone collects.
    recorded = {episode_seed(0, task.env, i) for task in plan.tasks for i in range(20_000)}
    assert not recorded & {job.seed for job in plan.jobs()}
    assert {task.env for task in plan.tasks} == set(ENV_IDS)
    assert plan_suite(suite, ["a"], seed=3).seed == 3
    assert plan_suite(find_suite("quick"), ["a"]).seed == 0


def test_every_task_of_every_suite_can_be_made() -> None:
    tasks = dict.fromkeys(task for suite in SUITES.values() for task in suite.tasks)
    assert {task.env for task in tasks} == set(ENV_IDS)
    for task in tasks:
        env = make_env(task)
        assert env.spec is not None
        assert env.spec.id == task.env
        env.close()


def test_robust_names_every_condition_of_its_promise() -> None:
    tasks = find_suite("robust").tasks
    fixtures = {dict(task.condition.options).get("num_fixtures", 2) for task in tasks}
    cables = {dict(task.condition.options).get("cable", "default") for task in tasks}
    assert fixtures == {1, 2, 3, 4}
    assert cables == {"default", "charging", "ethernet", "rope"}
    for env in {task.env for task in tasks}:
        conditions = {task.condition for task in tasks if task.env == env}
        assert Condition() in conditions
        assert any(condition.action_noise for condition in conditions)
        assert any(condition.observation_noise for condition in conditions)
        assert any(condition.planner_mass != 1.0 for condition in conditions)
        assert any(("obs_mode", "partial") in condition.options for condition in conditions)


def test_other_scenes_are_not_the_suite() -> None:
    full = find_suite("full")
    assert plan_suite(full, ["a"]).suite == full.title
    assert plan_suite(full, ["a"], seed=full.seed).suite == full.title
    assert plan_suite(full, ["a"], seed=777).suite == ""
    assert plan_suite(find_suite("validation"), ["a"], seed=0).suite == ""
