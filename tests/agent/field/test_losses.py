"""The distance that descriptors are taught, on cases that can be worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from icd_agent.field.config import FieldConfig
from icd_agent.field.field import FieldOutput
from icd_agent.field.losses import SIDE, Truth, contact_distance, field_loss, metric_error

SCALE = 0.03
CONFIG = FieldConfig(close_scale=SCALE, length_scale=SCALE)
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def truth(*points: tuple[tuple[float, float, float], float, tuple[float, float, float]]) -> Truth:
    places, distances, gradients = zip(*points, strict=True)
    return Truth(*(torch.tensor(part)[None] for part in (places, distances, gradients)))


def pair(*indices: tuple[int, int]) -> tuple[torch.Tensor, torch.Tensor]:
    first, second = zip(*indices, strict=True)
    return torch.tensor(first), torch.tensor(second)


def test_near_surfaces_small_distances_are_those_of_space() -> None:
    points = truth(((0, 0, 0), 0.0, UP), ((0.001, 0, 0), 0.0, UP))
    found = SCALE * float(contact_distance(points, pair((0, 1)), CONFIG))
    assert found == pytest.approx(0.001, rel=0.02)


def test_distances_shrink_far_from_surfaces_and_are_symmetric() -> None:
    points = truth(
        ((0, 0, 0), 0.0, UP),
        ((0.05, 0, 0), 0.0, UP),
        ((0, 0, 0.3), 0.3, UP),
        ((0.05, 0, 0.3), 0.3, UP),
    )
    near, far, there, back = contact_distance(points, pair((0, 1), (2, 3), (0, 3), (3, 0)), CONFIG)[
        0
    ].tolist()
    assert near == pytest.approx(math.log(1 + 0.05 / 0.03))
    assert far == pytest.approx(math.log(1 + 0.05 / 0.33))
    assert there == back


def test_the_two_sides_of_a_thin_wall_are_apart() -> None:
    points = truth(((0, 0, 0.002), 0.0, UP), ((0, 0, -0.002), 0.0, DOWN))
    assert float(contact_distance(points, pair((0, 1)), CONFIG)) >= 2 * SIDE


def test_descriptors_of_the_right_distances_have_no_error() -> None:
    # On a line far from everything the metric is that of the line, shrunk.
    points = truth(((0, 0, 9.0), 9.0, UP), ((0.01, 0, 9.0), 9.0, UP))
    pairs = pair((0, 1))
    right = contact_distance(points, pairs, CONFIG)[0, 0]
    descriptors = torch.zeros(1, 2, 4)
    descriptors[0, 1, 2] = right
    assert float(metric_error(descriptors, points, pairs, CONFIG)) < 1e-4
    assert float(metric_error(3 * descriptors + 1, points, pairs, CONFIG)) < 0.01
    descriptors[0, 1, 2] = 1.0
    assert float(metric_error(descriptors, points, pairs, CONFIG)) > 1.0


def test_a_field_that_is_right_has_a_small_loss_and_full_rates() -> None:
    rng = np.random.default_rng(0)
    places = torch.from_numpy(rng.uniform(-0.02, 0.02, (1, 50, 3)))
    # A floor: solid below z = 0.
    known = Truth(places, places[..., 2], torch.tensor(UP).double().expand(1, 50, 3))
    pairs = pair((0, 1), (2, 3))
    log_distance = torch.log1p(known.distance.abs() / SCALE)
    out = FieldOutput(places / SCALE, -1e4 * known.distance, known.gradient, log_distance)
    right = field_loss(out, known, pairs, CONFIG)
    assert float(right["iou"]) == float(right["cosine"]) == 1.0
    assert float(right["occupancy"]) < 0.1
    assert float(right["direction"]) == float(right["distance"]) == 0.0
    wrong = field_loss(out._replace(gradient=-known.gradient), known, pairs, CONFIG)
    assert float(wrong["loss"] - right["loss"]) == pytest.approx(4.0)
