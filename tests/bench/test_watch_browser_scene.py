"""What is sent to the browser, on a stand-in for viser's scene."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any

import numpy as np
import pytest

from benchmarks.watch.browser_scene import PARTS, BrowserScene
from benchmarks.watch.session import Session
from icd_envs import ENV_IDS
from icd_envs.drawing import CURRENT_RGBA, GHOST_EVERY, GOAL_RGBA, OBJECT_RGBA
from tests.bench.watched import CABLE, Dreamer, Still, spec


class Node:
    """Anything in the scene."""

    def __init__(self, scene: FakeScene, name: str, **values: Any) -> None:  # noqa: ANN401
        self._scene, self._name = scene, name
        self.visible = values.pop("visible", True)
        self.position: Any = values.pop("position", np.zeros(3))
        self.values = values

    def remove(self) -> None:
        for name in [n for n in self._scene.nodes if (n + "/").startswith(self._name + "/")]:
            del self._scene.nodes[name]


class FakeScene:
    """Keeps what is in the scene, by name, as viser does."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}

    def _add(self, name: str, **values: Any) -> Node:  # noqa: ANN401
        assert name.count("/") < 2 or name.rsplit("/", 1)[0] in self.nodes, "no parent"
        self.nodes[name] = Node(self, name, **values)
        return self.nodes[name]

    def configure_default_lights(self, *, cast_shadow: bool) -> None:
        assert not cast_shadow

    def add_grid(self, name: str, width: float, height: float, **more: Any) -> Node:  # noqa: ANN401
        return self._add(name)

    def add_frame(self, name: str, *, show_axes: bool, visible: bool) -> Node:
        assert not show_axes
        return self._add(name, visible=visible)

    def add_point_cloud(self, name: str, points: Any, colors: Any, **more: Any) -> Node:  # noqa: ANN401
        assert points.shape[1:] == (3,)
        assert points.dtype == np.float32
        return self._add(name, points=points, colour=tuple(colors))

    def add_line_segments(self, name: str, points: Any, colors: Any, **more: Any) -> Node:  # noqa: ANN401
        assert points.shape[1:] == (2, 3)
        return self._add(name, points=points, colour=tuple(colors))

    def add_mesh_simple(self, name: str, vertices: Any, faces: Any, **more: Any) -> Node:  # noqa: ANN401
        return self._add(name, vertices=vertices, position=more["position"])


class FakeServer:
    """No server at all."""

    def __init__(self) -> None:
        self.scene = FakeScene()

    def atomic(self) -> Any:  # noqa: ANN401
        return nullcontext()


@pytest.fixture
def server() -> FakeServer:
    return FakeServer()


@pytest.fixture(scope="module")
def dreaming() -> Iterator[Session]:
    session = Session(spec(Dreamer), CABLE)
    yield session
    session.close()


def scene_of(server: Any) -> tuple[BrowserScene, dict[str, Node]]:  # noqa: ANN401
    return BrowserScene(server), server.scene.nodes


def byte(rgba: tuple[float, ...]) -> tuple[int, ...]:
    return tuple(round(255 * part) for part in rgba[:3])


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_clouds_fixtures_and_hand_of_every_environment(server: FakeServer, env_id: str) -> None:
    session = Session(spec(Still), env_id)
    drawn, nodes = scene_of(server)
    moment = session.begin(0)
    drawn.begin(session.env, moment)
    for name, cloud, rgba in (
        ("/object/cloud", "achieved_goal", OBJECT_RGBA),
        ("/goal/cloud", "desired_goal", GOAL_RGBA),
    ):
        observed: Any = moment.observation[cloud]  # type: ignore[literal-required]
        np.testing.assert_array_equal(nodes[name].values["points"], observed)
        assert nodes[name].values["colour"] == byte(rgba)
    hand = [name for name in nodes if name.startswith("/hand/")]
    assert len(hand) == 3
    assert {name: node.visible for name, node in nodes.items() if name[1:] in PARTS} == {
        f"/{part}": visible for part, visible in PARTS.items()
    }
    fixtures = [node for name, node in nodes.items() if name.startswith("/fixtures/")]
    assert len(fixtures) >= 2
    at = np.array([node.position for node in fixtures])
    scene = moment.observation["scene"]
    assert (np.linalg.norm(scene[:, None] - at, axis=-1).min(axis=0) < 0.3).all()
    session.close()


def test_hand_goes_where_the_gripper_is(server: FakeServer, dreaming: Session) -> None:
    drawn, nodes = scene_of(server)
    drawn.begin(dreaming.env, dreaming.begin(0))
    moment = dreaming.advance()
    drawn.draw(moment)
    np.testing.assert_allclose(nodes["/hand"].position, moment.observation["observation"][:3])
    palm = nodes["/hand/palm"].position
    np.testing.assert_allclose(palm, [0.0, 0.0, 0.085], atol=1e-6)


def test_subgoals_ahead_plan_and_samples_are_drawn(server: FakeServer, dreaming: Session) -> None:
    drawn, nodes = scene_of(server)
    drawn.begin(dreaming.env, dreaming.begin(0))
    assert len(nodes["/subgoals/next"].values["points"] if "/subgoals/next" in nodes else []) == 0
    moment = dreaming.advance()
    drawn.draw(moment)
    plan, future = moment.plan, moment.future
    assert plan is not None
    assert plan.subgoals is not None
    assert future is not None
    following = nodes["/subgoals/next"].values
    np.testing.assert_array_equal(following["points"], plan.subgoals[1][::GHOST_EVERY])
    assert following["colour"] == byte(CURRENT_RGBA)
    later = nodes["/subgoals/later"].values["points"]
    np.testing.assert_array_equal(later, plan.subgoals[2][::GHOST_EVERY])
    np.testing.assert_array_equal(nodes["/plan/end"].values["points"], future.end)
    path = nodes["/plan/paths"].values["points"]
    np.testing.assert_array_equal(path[:, 0], future.path[:-1])
    np.testing.assert_array_equal(path[:, 1], future.path[1:])
    assert nodes["/best samples/paths"].values["points"].shape == (2 * 9, 2, 3)
    assert nodes["/their ends/clouds"].values["points"].shape == (400, 3)


def test_agent_without_plans_leaves_these_parts_empty(server: FakeServer) -> None:
    session = Session(spec(Still), CABLE)
    drawn, nodes = scene_of(server)
    drawn.begin(session.env, session.begin(0))
    drawn.draw(session.advance())
    for name in ("/plan/paths", "/plan/end", "/best samples/paths", "/their ends/clouds"):
        assert len(nodes[name].values["points"]) == 0
    session.close()


def test_subgoals_are_sent_again_only_when_they_change(
    server: FakeServer, dreaming: Session
) -> None:
    drawn, nodes = scene_of(server)
    drawn.begin(dreaming.env, dreaming.begin(0))
    moment = dreaming.advance()
    drawn.draw(moment)
    before = nodes["/subgoals/next"]
    drawn.draw(moment)
    assert nodes["/subgoals/next"] is before
    drawn.draw(dreaming.advance())
    assert nodes["/subgoals/next"] is not before


def test_toggles_outlive_the_scene(server: FakeServer, dreaming: Session) -> None:
    drawn, nodes = scene_of(server)
    drawn.begin(dreaming.env, dreaming.begin(0))
    drawn.set_visible("goal", False)
    drawn.set_visible("scene cloud", True)
    names = set(nodes)
    drawn.begin(dreaming.env, dreaming.begin(1))
    assert (nodes["/goal"].visible, nodes["/scene cloud"].visible) == (False, True)
    assert set(nodes) == names
