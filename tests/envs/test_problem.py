"""Which of the scenes that are drawn an episode starts from; a toy task without physics."""

from __future__ import annotations

import itertools
from typing import Any, ClassVar

import numpy as np
import pytest

from icd_envs.api import Float64Array, Oracle
from icd_envs.errors import SceneGenerationError
from icd_envs.tasks import problem
from icd_envs.tasks.base import Scenes

Scene = tuple[str, int]
"""Where it is, and which draw it comes from."""


class Toy:
    """Draws pairs of numbered scenes, and remembers how many."""

    env_id: ClassVar[str] = "Toy-v0"
    foreign: ClassVar[bool] = True

    def __init__(self) -> None:
        self.drawn = 0

    def draw_scenes(self, rng: np.random.Generator) -> Scenes[Scene]:
        self.drawn += 1
        scene = "here", self.drawn
        return Scenes(scene, ("there", self.drawn) if self.foreign else scene)

    def make_plant(self, scene: Scene) -> str:
        return f"plant of {scene}"

    def parameters(self, scene: Scene) -> dict[str, Float64Array]:
        place, draw = scene
        return {"draw": np.array([draw if place == "here" else -draw], dtype=float)}


class Familiar(Toy):
    """The goal is specified in the present scene."""

    foreign = False


def solve_all_but(unsolved: set[Scene], monkeypatch: pytest.MonkeyPatch) -> list[Scene]:
    """Replace the expert; returns the scenes that it is asked to solve, as it goes."""
    asked: list[Scene] = []

    def solve(task: Toy, scene: Scene, plant: str) -> Oracle | None:
        assert plant == task.make_plant(scene)
        asked.append(scene)
        points = np.full((2, 1, 3), float(scene[1]), dtype=np.float32)
        actions = np.zeros((1, 3), dtype=np.float32)
        return None if scene in unsolved else Oracle(scene, points, actions)

    monkeypatch.setattr(problem, "_solve", solve)
    return asked


def draw(task: Toy) -> problem.Problem[Any]:
    return problem.draw_problem(task, np.random.default_rng(0), seed=7)  # type: ignore[arg-type]


@pytest.mark.parametrize("place", ["here", "there"])
def test_twenty_scenes_are_drawn_before_giving_up_and_seed_and_id_are_named(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = Toy()
    never = {(place, draw) for draw in range(1, 100)}
    solve_all_but(never, monkeypatch)
    with pytest.raises(SceneGenerationError, match=r"Toy-v0: .*none of 20 scenes .*seed 7:"):
        draw(task)
    assert task.drawn == 20


def test_twentieth_scene_is_still_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    solve_all_but({("here", draw) for draw in range(1, 20)}, monkeypatch)
    assert draw(Toy()).scene == ("here", 20)


@pytest.mark.parametrize("place", ["here", "there"])
def test_scenes_of_the_next_draw_are_taken_if_either_is_not_solved(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = solve_all_but({(place, 1)}, monkeypatch)
    found = draw(Toy())
    assert (found.scene, found.goal_scene) == (("here", 2), ("there", 2))
    assert (found.oracle.scene, found.goal_oracle.scene) == (("here", 2), ("there", 2))
    assert found.plant == "plant of ('here', 2)"
    parameters = {name: value.tolist() for name, value in found.parameters.items()}
    assert parameters == {"draw": [2.0], "goal_draw": [-2.0]}
    assert np.all(found.goal == 2.0)
    first = [("here", 1), ("there", 1)] if place == "there" else [("here", 1)]
    assert asked == [*first, ("here", 2), ("there", 2)]


def test_goal_of_the_present_scene_is_its_own_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = solve_all_but(set(), monkeypatch)
    found = draw(Familiar())
    assert found.goal_scene is found.scene
    assert found.goal_oracle is found.oracle
    assert asked == [("here", 1)]


def test_no_two_generators_of_an_episode_share_a_stream() -> None:
    scenes = [problem.scene_rng(split, seed) for split in problem.SPLITS for seed in (0, 1)]
    sensors = [
        problem.sensor_rng(split, seed, step)
        for split, seed, step in itertools.product(problem.SPLITS, (0, 1), (0, 1))
    ]
    assert len({rng.integers(2**63) for rng in [*scenes, *sensors]}) == len(scenes) + len(sensors)
