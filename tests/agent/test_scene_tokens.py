"""What models are told of a scene turns and moves with it, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from icd_agent.field.space import exact_features
from icd_agent.scene_tokens import HEIGHTS, REACH, SURFACE, TOKENS, SceneTokens, scene_tokens
from icd_envs.api import Float32Array
from tests.agent.field.small import SMALL, small_data, small_field


@pytest.fixture(scope="module")
def scene() -> Float32Array:
    return small_data().draw(1, 4, np.random.default_rng(0))[0][0].numpy()


@settings(max_examples=10, deadline=None)
@given(yaw=st.floats(-3.0, 3.0), x=st.floats(-1.0, 1.0), y=st.floats(-1.0, 1.0))
def test_nothing_tells_where_in_the_world_a_scene_is(
    scene: Float32Array, yaw: float, x: float, y: float
) -> None:
    field = small_field()
    middle = np.array([0.3, -0.2, 0.1])
    turn = Rotation.from_euler("z", yaw)

    def seen(places: Float32Array, about: np.ndarray) -> Float32Array:
        return scene_tokens(field, places).seen_from(about, 0.2)

    before = seen(scene, middle)
    shift = np.array([x, y, 0.0])
    after = seen((turn.apply(scene) + shift).astype(np.float32), turn.apply(middle) + shift)
    assert before.shape == (TOKENS, 3 + SMALL.descriptor)
    np.testing.assert_allclose(after, before, atol=2e-3)


def test_the_object_is_ahead(scene: Float32Array) -> None:
    tokens = scene_tokens(small_field(), scene)
    origin = tokens.places[:SURFACE].mean(axis=0)
    toward = tokens.places[5] - origin
    seen = tokens.seen_from(origin + 3.0 * toward, 0.2)
    np.testing.assert_allclose(seen[5, :2], [np.linalg.norm(toward[:2]) / 0.2, 0.0], atol=1e-4)
    np.testing.assert_allclose(seen[:SURFACE, :2].mean(axis=0), 0.0, atol=1e-5)


def test_an_object_right_above_the_scene_is_no_error(scene: Float32Array) -> None:
    tokens = scene_tokens(small_field(), scene)
    seen = tokens.seen_from(tokens.places[:SURFACE].mean(axis=0), 0.2)
    assert np.isfinite(seen).all()


def test_the_lattice_surrounds_the_fixtures_and_says_what_the_field_says(
    scene: Float32Array,
) -> None:
    field = small_field()
    tokens = scene_tokens(field, scene)
    lattice, origin = tokens.places[SURFACE:], tokens.places[:SURFACE].mean(axis=0)
    np.testing.assert_allclose(lattice[:, :2].mean(axis=0), origin[:2], atol=1e-5)
    np.testing.assert_allclose(np.unique(lattice[:, 2].round(4)), HEIGHTS, atol=1e-4)
    away = np.linalg.norm(lattice[:, :2] - origin[:2], axis=1)
    assert away.max() == pytest.approx(REACH * np.sqrt(2), abs=1e-4)
    floor = scene[:, 2].min()  # some of the cloud lies on it
    asked = lattice + np.array([0.0, 0.0, floor], np.float32)
    expected = exact_features(field, scene)(asked[None])[0] / field.config.length_scale
    np.testing.assert_allclose(tokens.features[SURFACE:], expected, atol=1e-3)


@settings(max_examples=20, deadline=None)
@given(yaw=st.floats(-3.0, 3.0), x=st.floats(-1.0, 1.0), y=st.floats(-1.0, 1.0))
def test_a_frame_moves_with_scene_and_object_and_can_be_left_again(
    scene: Float32Array, yaw: float, x: float, y: float
) -> None:
    points = np.random.default_rng(0).normal(size=(2, 7, 3))
    middle = points[0].mean(axis=0)
    turn, shift = Rotation.from_euler("z", yaw), np.array([x, y, 0.0])

    def moved(values: np.ndarray) -> np.ndarray:
        return turn.apply(values.reshape(-1, 3)).reshape(values.shape) + shift

    tokens = SceneTokens(scene[:60], scene[:60])
    frame = tokens.frame(middle)
    after = SceneTokens(moved(scene[:60]), scene[:60]).frame(moved(middle))
    np.testing.assert_allclose(after.place(moved(points)), frame.place(points), atol=1e-4)
    np.testing.assert_allclose(frame.back(frame.place(points)), points, atol=1e-6)
    np.testing.assert_allclose(frame.place(middle[None])[0, 1], 0.0, atol=1e-6)
