"""Several goals for one scene: through a clip, behind it, or without touching it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from icd_envs.errors import InvalidOptionError
from icd_envs.geometry.routing import passes_behind, signed_crossings
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.scenes.cable_routing import CONTACTS, ROUTED, CableRoutingScene, draw_contacts
from icd_envs.tasks.base import HOLD_STEPS, run_expert
from icd_envs.tasks.cable_routing import UNTOUCHED, CableRouting
from icd_envs.tasks.problem import draw_problem, matched_parts, scene_rng
from tests.envs.making import CABLE, make

SEEDS = range(12)


def test_contacts_are_drawn_evenly_but_one_is_through() -> None:
    rng = np.random.default_rng(0)
    counts = Counter(draw_contacts(rng, 2) for _ in range(5000))
    assert len(counts) == len(CONTACTS) ** 2 - 4
    for contacts, count in counts.items():
        assert "through" in contacts
        assert count == pytest.approx(1000, abs=150)
    assert {draw_contacts(rng, 1) for _ in range(20)} == {("through",)}


def test_goal_passes_every_clip_as_asked_and_the_start_never_does() -> None:
    env = make(CABLE, goals="contact")
    asked = Counter()
    for seed in SEEDS:
        observation, info = env.reset(seed=seed)
        oracle = env.episode(oracle=True).oracle
        assert oracle is not None
        scene, goal = oracle.scene, observation["desired_goal"]
        assert isinstance(scene, CableRoutingScene)
        assert not info["is_success"]
        crossings = signed_crossings(goal, scene.clip_poses)
        for clip, contact, crossing in zip(scene.clips, scene.contacts, crossings, strict=True):
            asked[contact] += 1
            assert (crossing != 0) == (contact == "through")
            if contact == "behind":
                assert passes_behind(goal, clip)
            if contact == "free":
                assert BoxUnion(clip.boxes())(goal).min() > UNTOUCHED + scene.cable.radius
    assert set(asked) == set(CONTACTS)
    env.close()


def test_success_is_to_pass_the_same_throats_and_no_other() -> None:
    env = make(CABLE, goals="contact")
    plain = make(CABLE)
    for seed in SEEDS:
        observation, info = env.reset(seed=seed)
        goal = observation["desired_goal"]
        crossings = signed_crossings(goal, info["clips"])
        if np.all(crossings != 0):
            continue
        plain.reset(seed=seed)
        oracle = plain.episode(oracle=True).oracle
        assert oracle is not None
        everywhere, start = oracle.points[-1], observation["achieved_goal"]
        there = {**info, "clips": plain.task.parameters(oracle.scene)["clips"]}  # type: ignore
        for achieved in (everywhere, start):
            found = signed_crossings(achieved, there["clips"])
            expected = 0.0 if np.array_equal(found, crossings) else -1.0
            assert env.compute_reward(achieved, goal, there) == expected == -1.0
        break
    else:
        pytest.fail("no goal left a clip out")
    for made in (env, plain):
        made.close()


def test_default_goals_are_to_route_and_a_misspelt_value_is_named() -> None:
    assert make().task.goals == "routed"
    with pytest.raises(InvalidOptionError, match="did you mean 'contact'"):
        make(CABLE, goals="contacts")


def test_contact_goals_are_judged_at_the_end_of_the_budget() -> None:
    env = make(CABLE, goals="contact")
    env.reset(seed=0)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    still = np.zeros(3)
    budget = env.task.max_steps
    ends = []
    for step in range(budget):
        action = oracle.actions[step] if step < len(oracle.actions) else still
        *_, terminated, truncated, info = env.step(action)
        ends.append((info["is_success"], terminated, truncated))
    held = [success for success, *_ in ends[len(oracle.actions) :]]
    assert len(held) > HOLD_STEPS
    assert all(held)
    assert not any(terminated for _, terminated, _ in ends)
    assert [truncated for *_, truncated in ends] == [False] * (budget - 1) + [True]
    env.close()


def test_passing_every_throat_is_right_for_another_goal_on_the_way_but_not_at_the_end() -> None:
    task = CableRouting(goals="contact")
    for seed in SEEDS:
        problem = draw_problem(task, scene_rng("test", seed), seed)
        if problem.scene.contacts[0] != "through" or problem.scene.contacts[1] == "through":
            continue
        routed = replace(problem.scene, contacts=ROUTED * 2)
        shown = run_expert(task, routed, problem.plant, task.make_expert(routed))
        right = [bool(matched_parts(task, problem, points).all()) for points in shown.points]
        assert sum(right) > HOLD_STEPS
        assert not right[-1]
        break
    else:
        pytest.fail("no goal asked for the first clip alone")
