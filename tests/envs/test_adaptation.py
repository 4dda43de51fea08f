"""Goals that were specified in another scene, and what is achieved there and here."""

from __future__ import annotations

import numpy as np
import pytest

from icd_envs.errors import InvalidOptionError
from icd_envs.scenes import cable_routing, notebook_folding
from icd_envs.scenes.boxes import rotation_z
from icd_envs.tasks.cable_routing import CableRoutingAdaptation
from icd_envs.tasks.notebook_folding import NotebookFoldingAdaptation
from icd_envs.tasks.problem import draw_problem, matched_parts, scene_rng
from tests.envs.making import make

CABLE = "ICDCableRoutingAdaptation-v0"
NOTEBOOK = "ICDNotebookFoldingAdaptation-v0"
SEEDS = range(5)


@pytest.mark.parametrize("clips", [1, 2, 3, 4])
def test_every_clip_is_moved_and_turned(clips: int) -> None:
    task = CableRoutingAdaptation(clips)
    for seed in SEEDS:
        scene, goal_scene = task.draw_scenes(np.random.default_rng(seed))
        moved = np.abs(scene.clip_poses - goal_scene.clip_poses)
        assert np.all(np.linalg.norm(moved[:, :2], axis=1) <= cable_routing.PERTURBED_DISTANCE)
        for clip, after in zip(goal_scene.clips, scene.clips, strict=True):
            local = rotation_z(clip.yaw).T @ (after.origin - clip.origin)
            assert abs(local[0]) >= cable_routing.PERTURBED_ACROSS
        low, high = cable_routing.PERTURBED_TURN
        assert np.all((moved[:, 2] >= low) & (moved[:, 2] <= high))
        assert scene.contacts == goal_scene.contacts
        assert scene.cable == goal_scene.cable


def test_table_is_moved_and_nothing_keeps_its_size() -> None:
    for seed in SEEDS:
        scenes = NotebookFoldingAdaptation().draw_scenes(np.random.default_rng(seed))
        now, then = (scene.table.parameters for scene in scenes)
        distance = float(np.hypot(*(now - then)[:2]))
        low, high = notebook_folding.PERTURBED_DISTANCE
        assert low <= distance <= high
        assert np.all(now != then)


@pytest.mark.parametrize("task", [CableRoutingAdaptation(), NotebookFoldingAdaptation()])
def test_solution_of_one_scene_solves_it_and_seldom_the_other(
    task: CableRoutingAdaptation | NotebookFoldingAdaptation,
) -> None:
    copied = []
    for seed in SEEDS:
        problem = draw_problem(task, scene_rng("test", seed), seed)
        assert matched_parts(task, problem, problem.oracle.points[-1]).all()
        copied.append(bool(matched_parts(task, problem, problem.goal).all()))
    assert sum(copied) <= 1


def test_routing_matches_in_whatever_scene_the_goal_is_from() -> None:
    env = make(CABLE)
    observation, info = env.reset(seed=0)
    episode = env.episode(oracle=True)
    assert episode.oracle is not None
    here, start, goal = episode.oracle.points[-1], episode.oracle.points[0], observation
    assert env.compute_reward(here, goal["desired_goal"], info) == 0.0
    assert env.compute_reward(start, goal["desired_goal"], info) == -1.0
    mistaken = {**info, "goal_clips": info["clips"]}
    assert env.compute_reward(here, goal["desired_goal"], mistaken) == -1.0


@pytest.mark.parametrize(
    ("env_id", "foreign"),
    [
        (CABLE, True),
        (NOTEBOOK, True),
        ("ICDCableRouting-v0", False),
        ("ICDNotebookFolding-v0", False),
    ],
)
def test_an_episode_says_whether_its_goal_is_of_another_scene(env_id: str, foreign: bool) -> None:
    env = make(env_id)
    observation, _ = env.reset(seed=0)
    assert env.episode().foreign_goal == foreign
    assert np.array_equal(observation["scene"], observation["goal_scene"]) != foreign


def test_notebook_matches_when_both_are_folded_on_their_tables_or_neither() -> None:
    env = make(NOTEBOOK)
    goal, info = env.reset(seed=0)
    episode = env.episode(oracle=True)
    assert episode.oracle is not None
    here, start = episode.oracle.points[-1], episode.oracle.points[0]
    assert env.compute_reward(here, goal["desired_goal"], info) == 0.0
    assert env.compute_reward(start, goal["desired_goal"], info) == -1.0
    assert env.compute_reward(here, start, info) == -1.0
    assert env.compute_reward(start, start, info) == 0.0


def test_options_are_those_of_the_plain_task() -> None:
    assert make(CABLE, num_fixtures=3).task.max_steps == 500
    with pytest.raises(InvalidOptionError, match="did you mean 'num_fixtures'"):
        make(CABLE, num_fixture=3)
    with pytest.raises(InvalidOptionError, match="num_fixtures"):
        make(NOTEBOOK, num_fixtures=2)
