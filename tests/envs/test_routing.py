from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from icd_envs.api import Float64Array
from icd_envs.geometry.routing import BEHIND, find_crossing, passes_behind, signed_crossings
from icd_envs.scenes.boxes import rotation_z
from icd_envs.scenes.clip import THROAT_X, WALL_BACK, WALL_HEIGHT, Clip, throat_height
from tests.envs.linking import clip_loop, closed, linking_number

SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-7.0, 7.0)
METRES = st.floats(-1.0, 1.0)
CLIPS = st.builds(lambda x, y, yaw: Clip((x, y), yaw), METRES, METRES, ANGLES)

MIDDLE = sum(THROAT_X) / 2
LOW = 0.4 * throat_height(MIDDLE)
ABOVE = throat_height(THROAT_X[1]) + 0.05


def smooth_cable(seed: int, clip: Clip) -> Float64Array:
    """(80, 3) curve that wanders through and around a clip.

    Its draws are continuous: that it passes within 1e-6 m of the throat's border, or has a corner
    in the throat's plane, has no probability worth a check.
    """
    rng = np.random.default_rng(seed)
    knots = rng.uniform([-0.08, -0.2, -0.02], [0.1, 0.2, 0.15], (rng.integers(4, 12), 3))
    curve = CubicSpline(np.arange(len(knots)), knots)(np.linspace(0, len(knots) - 1, 80))
    return curve @ rotation_z(clip.yaw).T + clip.origin


def pose(clip: Clip) -> Float64Array:
    return np.array([[*clip.position, clip.yaw]])


def count(cable: Float64Array, clip: Clip) -> int:
    return int(signed_crossings(cable, pose(clip))[0])


@settings(max_examples=200, deadline=None)
@given(SEEDS, CLIPS)
def test_count_equals_the_linking_number(seed: int, clip: Clip) -> None:
    cable = smooth_cable(seed, clip)
    linking = linking_number(closed(cable), clip_loop(clip))
    assert linking == pytest.approx(round(linking), abs=1e-6)
    assert count(cable, clip) == round(linking)


def test_random_cables_pass_in_every_way() -> None:
    clip = Clip((0.3, -0.1), 0.7)
    found = {count(smooth_cable(seed, clip), clip) for seed in range(400)}
    assert {-1, 0, 1} < found


def test_linking_number_of_two_rings_is_one_and_of_separate_rings_zero() -> None:
    angle = np.linspace(0.0, 2 * np.pi, 40, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    through = np.column_stack([1 + np.cos(angle), np.zeros(40), np.sin(angle)])
    assert abs(linking_number(ring, through)) == pytest.approx(1.0, abs=1e-9)
    assert linking_number(ring, through) == pytest.approx(-linking_number(ring, through[::-1]))
    assert linking_number(ring, np.add(through, [0.0, 0.0, 3.0])) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=200, deadline=None)
@given(SEEDS, CLIPS)
def test_a_crossing_is_found_where_the_count_is_not_zero(seed: int, clip: Clip) -> None:
    cable = smooth_cable(seed, clip)
    assert (find_crossing(cable, clip) is None) == (count(cable, clip) == 0)


@settings(max_examples=50, deadline=None)
@given(SEEDS, CLIPS, ANGLES, METRES, METRES)
def test_count_does_not_depend_on_the_frame(
    seed: int, clip: Clip, turn: float, dx: float, dy: float
) -> None:
    cable = smooth_cable(seed, clip)
    shift = np.array([dx, dy, 0.0])
    moved = rotation_z(turn) @ clip.origin + shift
    there = Clip((float(moved[0]), float(moved[1])), clip.yaw + turn)
    assert count(cable @ rotation_z(turn).T + shift, there) == count(cable, clip)


@settings(max_examples=50, deadline=None)
@given(SEEDS, CLIPS)
def test_reversed_cable_counts_the_other_way(seed: int, clip: Clip) -> None:
    cable = smooth_cable(seed, clip)
    assert count(cable[::-1], clip) == -count(cable, clip)


def test_batch_equals_each_cable_and_clip_alone() -> None:
    clips = [Clip((0.0, 0.0), 0.3), Clip((0.05, 0.1), -2.0)]
    cables = np.stack([smooth_cable(seed, clips[seed % 2]) for seed in range(30)])
    poses = np.concatenate([pose(clip) for clip in clips])
    batch = signed_crossings(cables.reshape(5, 6, 80, 3), poses)
    assert batch.shape == (5, 6, 2)
    single = [[count(cable, clip) for clip in clips] for cable in cables]
    np.testing.assert_array_equal(batch.reshape(30, 2), single)
    own = signed_crossings(cables, np.broadcast_to(poses, (30, 2, 3)))
    np.testing.assert_array_equal(own, single)


def line(*corners: tuple[float, float, float]) -> Float64Array:
    return np.array(corners, dtype=float)


THROUGH = [(MIDDLE, -0.1, LOW), (MIDDLE, 0.1, LOW)]
BESIDE = THROAT_X[1] + 0.1


@pytest.mark.parametrize(
    ("cable", "expected"),
    [
        pytest.param(line(*THROUGH), 1, id="through"),
        pytest.param(line(*THROUGH[::-1]), -1, id="through, against the axis"),
        pytest.param(line((-0.1, -0.1, LOW), (-0.1, 0.1, LOW)), 0, id="behind the wall"),
        pytest.param(line((MIDDLE, -0.1, ABOVE), (MIDDLE, 0.1, ABOVE)), 0, id="over the lip"),
        pytest.param(line((BESIDE, -0.1, LOW), (BESIDE, 0.1, LOW)), 0, id="before the mouth"),
        pytest.param(line((BESIDE, 0.01, LOW), (MIDDLE, 0.01, LOW)), 0, id="in, not through"),
        pytest.param(line(*THROUGH, *THROUGH[::-1]), 0, id="through and back"),
        pytest.param(
            line(*THROUGH, (BESIDE, 0.1, LOW), (BESIDE, -0.1, LOW), *THROUGH), 2, id="twice round"
        ),
        pytest.param(
            line(*THROUGH, (-0.2, 0.1, LOW), (-0.2, -0.1, LOW)), 1, id="through, back behind"
        ),
    ],
)
@pytest.mark.parametrize("clip", [Clip((0.0, 0.0), 0.0), Clip((0.4, -0.2), 2.5)])
def test_known_cables(cable: Float64Array, expected: int, clip: Clip) -> None:
    world = cable @ rotation_z(clip.yaw).T + clip.origin
    assert count(world, clip) == expected
    crossing = find_crossing(world, clip)
    assert (crossing is None) == (expected == 0)
    if crossing is not None:
        assert crossing.segment == 0
        assert crossing.depth == pytest.approx(MIDDLE)


def test_point_on_the_plane_is_counted_once() -> None:
    clip = Clip((0.0, 0.0), 0.0)
    for corner in ((MIDDLE, 0.0, LOW), (MIDDLE, -0.0, LOW)):
        assert count(line(THROUGH[0], corner, THROUGH[1]), clip) == 1
        assert count(line(THROUGH[1], corner, THROUGH[0]), clip) == -1
        assert count(line(THROUGH[0], corner, THROUGH[0]), clip) == 0


@pytest.mark.parametrize(
    ("x", "z", "expected"),
    [
        (WALL_BACK - 0.01, 0.02, True),
        (WALL_BACK - BEHIND + 0.01, WALL_HEIGHT - 0.01, True),
        (WALL_BACK - BEHIND - 0.01, 0.02, False),
        (WALL_BACK - 0.01, WALL_HEIGHT + 0.01, False),
        (MIDDLE, 0.02, False),
        (THROAT_X[1] + 0.1, 0.02, False),
    ],
)
@pytest.mark.parametrize("clip", [Clip((0.0, 0.0), 0.0), Clip((0.4, -0.2), 2.5)])
def test_behind_is_along_the_back_of_the_wall(
    clip: Clip, x: float, z: float, expected: bool
) -> None:
    there = np.array([[x, -0.3, z], [x, 0.01, z], [x, 0.3, z]])
    forth_and_back = np.concatenate([there, there[::-1]])
    for cable, found in ((there, expected), (there[::-1], expected), (forth_and_back, False)):
        assert passes_behind(cable @ rotation_z(clip.yaw).T + clip.origin, clip) == found
