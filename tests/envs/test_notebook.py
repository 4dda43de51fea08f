from __future__ import annotations

import itertools
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from icd_envs.demonstrations import demonstrate
from icd_envs.experts.notebook_folding import Fault, NotebookFoldingExpert, Style, draw_style
from icd_envs.geometry.folding import COLUMNS, FOLDED, ROWS, cover_gap, fold_gap, on_top
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.physics.plant import Plant, TrackedCloud, TrackedSheet
from icd_envs.scenes.notebook import DEFAULT_NOTEBOOK, NotebookSpec
from icd_envs.scenes.notebook_folding import NotebookFoldingScene, build_scene
from icd_envs.tasks.base import HOLD_STEPS, Demonstration, run_expert
from icd_envs.tasks.notebook_folding import GOAL_DISTANCE, NotebookFolding
from icd_envs.tasks.problem import draw_problem, scene_rng
from tests.envs.making import make, random_actions

NOTEBOOK = "ICDNotebookFolding-v0"
TASK = NotebookFolding()
SPECS = [DEFAULT_NOTEBOOK, NotebookSpec(width=0.2, cover=0.12, spine=0.03, mass=0.08)]
SEEDS = range(3)

MAY_TOUCH = {
    frozenset({"contact", "table"}),
    frozenset({"contact", "obstacle"}),
    frozenset({"contact", "floor"}),
    frozenset({"gripper", "table"}),
    frozenset({"gripper", "obstacle"}),
    frozenset({"held contact", "free cover"}),
}


def kind(geom: str) -> str:
    """The layer a geom of the scene should be in, by its name."""
    name, _, number = geom.partition("_")
    spec = DEFAULT_NOTEBOOK
    if name == "sheet":
        return "free cover" if spec.is_free(int(number)) else "rest of the sheet"
    if name == "contact":
        return "held contact" if int(number.partition("_")[0]) < spec.cover_strips else "contact"
    return {"palm": "gripper", "finger": "gripper", "stripe": "rest of the sheet"}.get(name, name)


def folded_cloud(angle: float) -> np.ndarray:
    """A canonical notebook whose covers enclose an angle [rad]; pi is flat, 0 closed."""
    spec = DEFAULT_NOTEBOOK
    x = np.linspace(-spec.length / 2, spec.length / 2, COLUMNS)
    side = np.linspace(0.0, spec.width, ROWS)
    along = np.stack([x * np.sin(angle / 2), np.abs(x) * np.cos(angle / 2)], axis=1)
    cloud = np.zeros((COLUMNS, ROWS, 3))
    cloud[..., 0], cloud[..., 2] = along[:, :1], along[:, 1:]
    cloud[..., 1] = side
    return cloud.reshape(-1, 3)


def perform(scene: NotebookFoldingScene, style: Style, seed: int = 0) -> Demonstration:
    expert = NotebookFoldingExpert(scene, TASK.action_scale, style, np.random.default_rng(seed))
    return run_expert(TASK, scene, TASK.make_plant(scene), expert)


def distance(points: np.ndarray, goal: np.ndarray) -> float:
    return float(np.linalg.norm(points - goal, axis=-1).mean())


@pytest.fixture(scope="module")
def plant() -> Plant:
    return TASK.make_plant(TASK.draw_scenes(np.random.default_rng(0)).scene)


@pytest.fixture(scope="module")
def scenes() -> list[NotebookFoldingScene]:
    """Scenes that the clean expert solves."""
    return [draw_problem(TASK, scene_rng("test", seed), seed).scene for seed in SEEDS]


@pytest.fixture(scope="module")
def clean(scenes: list[NotebookFoldingScene]) -> list[Demonstration]:
    return [perform(scene, Style()) for scene in scenes]


@pytest.mark.parametrize("spec", SPECS)
def test_mass_and_length_are_spread_over_the_strips(spec: NotebookSpec) -> None:
    scene = replace(TASK.draw_scenes(np.random.default_rng(0)).scene, notebook=spec)
    model = mujoco.MjModel.from_xml_string(build_scene(scene).to_xml_string())
    masses = [model.body(f"strip_{i}").mass[0] for i in range(len(spec.strips))]
    assert sum(masses) == pytest.approx(spec.mass)
    np.testing.assert_allclose(masses, spec.mass * spec.strips / spec.length)
    assert spec.edges[-1] == pytest.approx(spec.length)
    assert model.nv == 3 + 1 + 2 * (len(spec.strips) - 1)


def test_sensors_are_the_ends_of_every_edge(plant: Plant) -> None:
    spec, nodes = DEFAULT_NOTEBOOK, plant.nodes()
    assert len(nodes) == 2 * len(spec.edges)
    np.testing.assert_allclose(np.linalg.norm(nodes[0::2] - nodes[1::2], axis=1), spec.width)
    names = [plant.model.sensor(i).name for i in range(plant.model.nsensor)]
    assert names == [f"node_{i}" for i in range(len(nodes))]


def test_cloud_is_a_grid_from_the_held_edge_and_from_left_to_right(plant: Plant) -> None:
    spec = DEFAULT_NOTEBOOK
    for cloud, tolerance in ((TASK.canonical_cloud(), 1e-6), (plant.points(), 2e-3)):
        grid = cloud.reshape(COLUMNS, ROWS, 3)
        np.testing.assert_allclose(grid[0, :, 0], 0.0, atol=tolerance)
        steps = -np.diff(grid, axis=0)[..., 0]
        np.testing.assert_allclose(steps, spec.length / (COLUMNS - 1), atol=tolerance)
        across = -np.diff(grid, axis=1)[..., 1]
        np.testing.assert_allclose(across, spec.width / (ROWS - 1), atol=tolerance)


def test_sheet_of_a_batch_has_the_bits_of_each_state_alone() -> None:
    rng = np.random.default_rng(0)
    along = TrackedCloud(rng.integers(0, 4, 50), rng.uniform(0, 1, (50, 1)))
    sheet = TrackedSheet(along, rng.uniform(0, 1, (50, 1)))
    nodes = rng.normal(size=(4, 7, 10, 3))
    alone = np.array([[sheet(state) for state in row] for row in nodes])
    assert sheet(nodes).tobytes() == alone.tobytes()
    assert sheet(nodes).dtype == np.float32


def test_sheet_lies_between_its_corners() -> None:
    corners = np.array([[0, 1, 0], [0, 0, 0], [2, 1, 4], [2, 0, 0]], dtype=float)
    along = TrackedCloud(np.array([0, 0, 0]), np.array([[0.0], [1.0], [0.5]]))
    sheet = TrackedSheet(along, np.array([[0.0], [1.0], [0.5]]))
    np.testing.assert_allclose(sheet(corners), [[0, 1, 0], [2, 0, 0], [1, 0.5, 1]])


def test_only_the_layers_that_should_touch_can(plant: Plant) -> None:
    model = plant.model
    kinds = [kind(model.geom(i).name) for i in range(model.ngeom)]
    able = set()
    for i, j in itertools.combinations(range(model.ngeom), 2):
        one, two = model.geom(i), model.geom(j)
        if one.contype[0] & two.conaffinity[0] or two.contype[0] & one.conaffinity[0]:
            pair = frozenset({kinds[i], kinds[j]})
            able.add(pair if "free cover" in pair else _plain(pair))
    assert able == MAY_TOUCH


def _plain(pair: frozenset[str]) -> frozenset[str]:
    return frozenset(name.removeprefix("held ") for name in pair)


def test_starts_flat_on_the_floor_and_at_rest(plant: Plant) -> None:
    spec = DEFAULT_NOTEBOOK
    points = plant.points()
    assert 0.5 * spec.radius < points[:, 2].min() <= points[:, 2].max() < 2.5 * spec.radius
    start = plant.get_state()
    for _ in range(10):
        plant.step(np.zeros(3))
    np.testing.assert_allclose(plant.points(), points, atol=1e-3)
    plant.set_state(start)


def test_strips_keep_their_length_under_any_motion(plant: Plant) -> None:
    start = plant.get_state()
    for action in random_actions(1, 60):
        plant.step(action)
        middle = plant.nodes().reshape(-1, 2, 3).mean(axis=1)
        steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
        np.testing.assert_allclose(steps, DEFAULT_NOTEBOOK.strips, atol=1e-9)
    assert not plant.diverged()
    plant.set_state(start)


@pytest.mark.parametrize("degrees", [0, 15, 45, 90, 180])
def test_fold_gap_is_the_chord_of_the_angle(degrees: int) -> None:
    angle = np.deg2rad(degrees)
    reach = np.abs(np.linspace(-0.5, 0.5, COLUMNS)).mean() * DEFAULT_NOTEBOOK.length
    gap = fold_gap(folded_cloud(angle))
    assert gap == pytest.approx(2 * reach * np.sin(angle / 2), abs=1e-9)
    assert (gap < FOLDED) == (degrees <= 15)


@pytest.mark.parametrize("every", [1, 4])
def test_cover_gap_is_the_fold_gap_of_stiff_covers_for_any_even_selection(every: int) -> None:
    for angle in np.linspace(0.0, np.pi, 5):
        cloud = folded_cloud(angle)
        count = len(cloud) // every
        kept = cloud[np.linspace(0, len(cloud) - 1, count).round().astype(int)]
        assert cover_gap(kept) == pytest.approx(float(fold_gap(cloud)), abs=6e-3)
        assert cover_gap(cloud[None, None]).shape == (1, 1)
        assert cover_gap(cloud) <= fold_gap(cloud) + 1e-12


def test_fold_gap_and_on_top_take_batches(scenes: list[NotebookFoldingScene]) -> None:
    clouds = np.stack([folded_cloud(a) for a in (0.0, 1.0, np.pi)])
    np.testing.assert_array_equal(fold_gap(clouds), [fold_gap(cloud) for cloud in clouds])
    tables = np.stack([scene.table.parameters for scene in scenes[:3]])
    placed = clouds + np.array([*scenes[0].table.position, scenes[0].table.height + 0.005])
    single = [[bool(on_top(cloud, table)) for table in tables] for cloud in placed]
    np.testing.assert_array_equal(on_top(placed[:, None], tables), single)
    assert len(np.unique(single)) == 2


@pytest.mark.parametrize(
    ("shift", "expected"),
    [
        ((0, 0, 0.005), True),
        ((0, 0, -0.01), False),
        ((0, 0, 0.1), False),
        ((0.5, 0, 0.005), False),
        ((0, 0.4, 0.005), False),
    ],
)
def test_on_top_means_above_and_within(
    scenes: list[NotebookFoldingScene], shift: tuple[float, float, float], expected: bool
) -> None:
    table = scenes[0].table
    cloud = folded_cloud(np.pi) + np.array([*table.position, table.height]) + shift
    cloud[:, 1] -= DEFAULT_NOTEBOOK.width / 2
    assert bool(on_top(cloud, table.parameters)) == expected


@pytest.mark.parametrize(
    ("yaw", "point", "expected"),
    [
        (0.0, (0.29, 0.0), True),
        (0.0, (0.31, 0.0), False),
        (0.0, (0.0, 0.11), False),
        (np.pi / 2, (0.0, 0.29), True),
        (np.pi / 2, (0.0, -0.31), False),
        (np.pi / 2, (0.11, 0.0), False),
        (0.6, (0.21, 0.14), True),
        (0.6, (0.21, -0.14), False),
        (0.6, (0.24, 0.16), True),
        (0.6, (0.26, 0.18), False),
        (-0.6, (0.21, 0.14), False),
        (-0.6, (0.21, -0.14), True),
    ],
)
def test_on_top_is_within_the_footprint_as_the_table_is_turned(
    yaw: float, point: tuple[float, float], expected: bool
) -> None:
    table = np.array([0.5, -0.2, yaw, 0.3, 0.1, 0.12])
    corner = np.array([[0.5 + point[0], -0.2 + point[1], 0.13]])
    assert bool(on_top(corner, table)) == expected
    middle = np.array([[0.5, -0.2, 0.13]])
    assert bool(on_top(np.concatenate([middle, corner]), table)) == expected


@pytest.mark.parametrize(
    ("height", "expected"), [(-0.0021, False), (-0.0019, True), (0.0599, True), (0.0601, False)]
)
def test_on_top_is_from_2_mm_below_the_tables_top_to_6_cm_above_it(
    height: float, expected: bool
) -> None:
    table = np.array([0.0, 0.0, 0.4, 0.3, 0.2, 0.12])
    lying = np.array([[0.0, 0.0, 0.121], [0.05, 0.0, 0.12 + height]])
    assert bool(on_top(lying, table)) == expected


def test_scenes_leave_the_notebook_room_to_rise() -> None:
    rng = np.random.default_rng(0)
    spec = DEFAULT_NOTEBOOK
    x = np.linspace(-spec.length, 0.03, 30)
    y = np.linspace(-spec.width / 2, spec.width / 2, 15)
    column = np.stack(np.meshgrid(x, y, np.linspace(0.01, 0.7, 30)), -1).reshape(-1, 3)
    counts = set()
    for _ in range(100):
        scene = TASK.draw_scenes(rng).scene
        counts.add(len(scene.obstacles))
        assert BoxUnion(scene.boxes())(column).min() > 0.005
    assert counts == {2, 3}


def test_clean_expert_folds_on_the_table_within_the_budget(
    scenes: list[NotebookFoldingScene], clean: list[Demonstration]
) -> None:
    for scene, run in zip(scenes, clean, strict=True):
        assert run.success
        assert HOLD_STEPS < run.steps <= TASK.max_steps
        held = run.points[-HOLD_STEPS:]
        assert np.all(fold_gap(held) < FOLDED)
        assert np.all(on_top(held, scene.table.parameters))


def test_nothing_passes_through_the_table_or_obstacles(
    scenes: list[NotebookFoldingScene], clean: list[Demonstration]
) -> None:
    for scene, run in zip(scenes, clean, strict=True):
        depth = BoxUnion(scene.boxes())(run.points.reshape(-1, 3).astype(float))
        assert depth.min() > -0.004
        assert run.points[..., 2].min() > 0.0


@pytest.mark.parametrize("fault", ["open", "beside"])
def test_open_or_beside_the_table_is_no_success(
    scenes: list[NotebookFoldingScene], clean: list[Demonstration], fault: Fault
) -> None:
    for scene, solved in zip(scenes, clean, strict=True):
        run = perform(scene, Style(fault=fault))
        assert not run.success
        goal = solved.points[-1]
        assert distance(run.points[-1], goal) > 1.5 * GOAL_DISTANCE
        assert not TASK.matches(run.points, np.broadcast_to(goal, run.points.shape), {}).any()


def test_unfolded_at_the_right_place_is_no_success(clean: list[Demonstration]) -> None:
    for run in clean:
        flat = run.points[len(run.points) // 2 :]
        laid = flat[np.argmax(fold_gap(flat))]
        assert not TASK.matches(laid[None], run.points[-1][None], {}).any()


def test_noisy_repeats_mostly_solve_the_same_scene(scenes: list[NotebookFoldingScene]) -> None:
    runs = [perform(scene, Style(noise=0.005, speed=0.025), 3) for scene in scenes]
    assert sum(run.success for run in runs) >= len(scenes) - 1
    assert all(np.abs(run.actions).max() <= 1.0 for run in runs)


def test_detour_goes_elsewhere_first(scenes: list[NotebookFoldingScene]) -> None:
    place = (-0.3, 0.2, 0.4)
    run = perform(scenes[0], Style(detour=place))
    held = run.points[:, :ROWS].mean(axis=1)
    assert np.linalg.norm(held - place, axis=1).min() < 0.04


def test_styles_are_mostly_good_and_always_valid() -> None:
    rng = np.random.default_rng(0)
    styles = [draw_style(rng) for _ in range(2000)]
    faulty = [style for style in styles if style.fault or style.detour]
    assert len(faulty) / len(styles) == pytest.approx(0.3, abs=0.04)
    assert {style.fault for style in styles} == {None, "open", "beside"}
    assert all(0 < s.speed <= TASK.action_scale and s.noise >= 0 for s in styles)


@pytest.mark.parametrize("noisy", [False, True])
def test_same_seed_gives_the_same_demonstration(noisy: bool) -> None:
    first, second = (demonstrate(NOTEBOOK, seed=3, noisy=noisy) for _ in range(2))
    assert first.actions.tobytes() == second.actions.tobytes()
    assert first.points.tobytes() == second.points.tobytes()
    assert not first.diverged


def test_rollout_and_steps_agree_bit_for_bit() -> None:
    env = make(NOTEBOOK)
    env.reset(seed=0)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    for action in oracle.actions[:60]:  # on the table, in contact
        env.step(action)
    simulator = env.episode(simulator=True, threads=2).simulator
    assert simulator is not None
    actions = random_actions(5, 3, 8)
    state = env.snapshot()
    rollout = simulator.rollout(state, actions)
    for k in range(3):
        env.restore(state)
        stepped = np.stack([env.step(action)[0]["achieved_goal"] for action in actions[k]])
        assert stepped.tobytes() == rollout.points[k].tobytes()
    env.close()
