"""What is drawn on top of a scene; MuJoCo fills a scene without OpenGL."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from icd_envs import drawing
from icd_envs.api import PlanView
from icd_envs.drawing import CURRENT_RGBA, GHOST_RGBA, GOAL_RGBA, PATH_RGBA, Overlay, ghosts
from icd_envs.errors import InvalidOptionError

MODEL = mujoco.MjModel.from_xml_string("<mujoco/>")
GOAL = np.random.default_rng(0).uniform(-1, 1, (30, 3)).astype(np.float32)
CHAIN = np.stack([GOAL + 0.1 * i for i in (3, 2, 1, 0)])


def drawn(overlay: Overlay, room: int = 1000) -> list[mujoco.MjvGeom]:
    """Every geom, in order."""
    scene = mujoco.MjvScene(MODEL, room)
    for geom in scene.geoms:
        geom.category, geom.transparent = 77, 99  # of an earlier picture
    overlay.add_to(scene)
    return list(scene.geoms[: scene.ngeom])


def count(geoms: list[mujoco.MjvGeom], rgba: drawing.Rgba) -> int:
    return sum(bool(np.allclose(geom.rgba, rgba)) for geom in geoms)


def test_goal_is_red_spheres_at_its_points() -> None:
    geoms = drawn(Overlay(GOAL))
    np.testing.assert_allclose([geom.pos for geom in geoms], GOAL)
    assert count(geoms, GOAL_RGBA) == len(GOAL)
    assert {geom.transparent for geom in geoms} == {0}
    assert {geom.category for geom in geoms} == {int(mujoco.mjtCatBit.mjCAT_DYNAMIC)}


def test_ghosts_are_the_subgoals_ahead_and_the_next_one_stands_out() -> None:
    for index, ahead in ((0, 3), (1, 2), (2, 1), (3, 0)):
        clouds = ghosts(PlanView(subgoals=CHAIN, subgoal=index), GOAL)
        for (cloud, _), subgoal in zip(clouds, CHAIN[index:3], strict=True):
            np.testing.assert_array_equal(cloud, subgoal)
        assert [rgba for _, rgba in clouds] == ([CURRENT_RGBA] + [GHOST_RGBA] * 3)[:ahead]


def test_colours_of_object_goal_and_subgoals_differ_and_ghosts_are_translucent() -> None:
    hues = [rgba[:3] for rgba in (drawing.OBJECT_RGBA, GOAL_RGBA, CURRENT_RGBA, PATH_RGBA)]
    apart = [np.abs(np.subtract(a, b)).max() for a in hues for b in hues if a is not b]
    assert min(apart) > 0.2
    assert GHOST_RGBA[3] < CURRENT_RGBA[3] < GOAL_RGBA[3] == drawing.OBJECT_RGBA[3] == 1.0


def test_plan_is_drawn_over_the_goal() -> None:
    plan = PlanView(subgoals=CHAIN, subgoal=1, paths=np.zeros((2, 10, 3)) + np.arange(3))
    geoms = drawn(Overlay(GOAL, plan))
    assert count(geoms, GOAL_RGBA) == 30
    assert count(geoms, CURRENT_RGBA) == count(geoms, GHOST_RGBA) == 10
    assert count(geoms, PATH_RGBA) == 2 * 9
    ghostly = [geom for geom in geoms if geom.rgba[3] < 1]
    assert {geom.transparent for geom in ghostly} == {1}
    assert {geom.category for geom in ghostly} == {int(mujoco.mjtCatBit.mjCAT_DECOR)}  # no shadow


def test_path_leads_from_point_to_point() -> None:
    path = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.4], [0.2, 0.0, 0.4]])
    geoms = drawn(Overlay(GOAL[:0], PlanView(paths=path[None])))
    np.testing.assert_allclose([g.pos for g in geoms], [[0, 0, 0.2], [0.1, 0, 0.4]], atol=1e-7)
    np.testing.assert_allclose([g.size[2] for g in geoms], [0.2, 0.1], atol=1e-7)


@pytest.mark.parametrize("room", [0, 1, 29, 30, 31, 40, 41, 42])
def test_what_finds_no_room_is_left_out(room: int) -> None:
    plan = PlanView(subgoals=CHAIN, subgoal=2, paths=np.zeros((1, 10, 3)) + np.arange(3))
    assert len(drawn(Overlay(GOAL, plan), room)) == room


@pytest.mark.parametrize("name", ["subgoals", "actions", "paths", "ends"])
@pytest.mark.parametrize("shape", [(3,), (4, 5), (2, 2, 4), (1, 2, 3, 3)])
def test_plan_of_another_shape_is_refused(name: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(InvalidOptionError, match=rf"PlanView\.{name} has shape"):
        PlanView(**{name: np.zeros(shape)})
