from __future__ import annotations

import pytest
import torch
from scipy.spatial import cKDTree

from icd_agent.field.neighbours import FAR, gather, nearest, spread


@pytest.fixture
def points() -> torch.Tensor:
    return torch.rand(2, 60, 3, dtype=torch.float64, generator=torch.manual_seed(0))


def test_nearest_agrees_with_a_tree(points: torch.Tensor) -> None:
    queries = torch.rand(2, 9, 3, dtype=torch.float64, generator=torch.manual_seed(1))
    squares, indices = nearest(queries, points, 5)
    for b in range(2):
        distances, expected = cKDTree(points[b].numpy()).query(queries[b].numpy(), 5)
        torch.testing.assert_close(indices[b], torch.from_numpy(expected))
        torch.testing.assert_close(squares[b], torch.from_numpy(distances**2))


def test_points_that_are_not_there_are_not_found(points: torch.Tensor) -> None:
    there = torch.zeros(2, 60, dtype=torch.bool)
    there[:, ::10] = True
    squares, indices = nearest(points, points, 6, there)
    assert set(indices.unique().tolist()) == set(range(0, 60, 10))
    assert float(squares.max()) < 3.0
    assert float(nearest(points, points, 7, there)[0][..., -1].min()) == FAR
    assert set(spread(points, 6, there).unique().tolist()) == set(range(0, 60, 10))


def test_spread_points_leave_no_point_far_away(points: torch.Tensor) -> None:
    there = torch.ones(2, 60, dtype=torch.bool)
    worst = []
    for count in (4, 16, 60):
        chosen = gather(points, spread(points, count, there))
        assert chosen.shape == (2, count, 3)
        worst.append(float(nearest(points, chosen, 1)[0].max()))
    assert worst[0] > worst[1] > worst[2] == 0.0


def test_spread_does_not_depend_on_place_or_turn(points: torch.Tensor) -> None:
    there = torch.ones(2, 60, dtype=torch.bool)
    turned = points.flip(-1) + 3.0
    torch.testing.assert_close(spread(turned, 20, there), spread(points, 20, there))


def test_gather_is_indexing(points: torch.Tensor) -> None:
    indices = torch.randint(60, (2, 7, 4), generator=torch.manual_seed(2))
    found = gather(points, indices)
    for b in range(2):
        torch.testing.assert_close(found[b], points[b, indices[b]])
