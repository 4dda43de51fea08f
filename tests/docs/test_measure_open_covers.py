"""What docs/tasks/notebook-folding.md says of notebooks that are not quite folded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from docs.tasks.measure_open_covers import ANGLES, COVER, between, moved, opened
from docs.tasks.render_threshold import distance
from icd_envs.geometry.folding import ROWS
from icd_envs.physics.plant import Plant
from icd_envs.tasks.base import run_expert
from icd_envs.tasks.notebook_folding import NotebookFolding, NotebookFoldingAdaptation
from icd_envs.tasks.problem import scene_rng

PAGE = Path(__file__).parents[2] / "docs" / "tasks" / "notebook-folding.md"
TASK = NotebookFolding()
SCENE = TASK.draw_scenes(scene_rng("train", 1)).scene


@pytest.fixture(scope="module")
def plant() -> Plant:
    """A notebook that the expert has folded."""
    plant = TASK.make_plant(SCENE)
    assert run_expert(TASK, SCENE, plant, TASK.make_expert(SCENE)).success
    return plant


def test_rigid_motion_is_found_again() -> None:
    rng = np.random.default_rng(0)
    cloud = rng.normal(size=(20, 3))
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    there = cloud @ turn + [1.0, 2.0, 3.0]
    np.testing.assert_allclose(moved(cloud, cloud[5:], there[5:]), there, atol=1e-9)


def test_free_cover_stays_in_place_and_nothing_else_changes(plant: Plant) -> None:
    folded, state = plant.points(), plant.get_state()
    cloud = opened(plant, np.radians(60))
    free = slice(-COVER * ROWS, None)
    np.testing.assert_allclose(cloud[free], folded[free], atol=1e-5)
    assert np.abs(cloud - folded).max() > 0.1
    assert plant.get_state().tobytes() == state.tobytes()


def test_page_tells_what_the_threshold_admits(plant: Plant) -> None:
    goal, page = plant.points()[None], PAGE.read_text("utf-8")
    table = {"table": SCENE.table.parameters[None], "goal_table": SCENE.table.parameters[None]}
    for angle in ANGLES:
        cloud = opened(plant, np.radians(angle))
        success = bool(TASK.matches(cloud[None], goal, table).all())
        told = f"| {between(cloud):.0f} | {distance(cloud, goal[0]):.4f} | "
        assert told + ("success |" if success else "|") in page
        assert success == (angle <= 77)
        assert not NotebookFoldingAdaptation().matches(cloud[None], goal, table).any() or angle < 30
