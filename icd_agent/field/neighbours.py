"""Nearest points, spread-out points, and gathering by index; batched."""

from __future__ import annotations

import torch
from torch import Tensor

FAR = 1e6
"""[m^2] squared distance of a point that is not there."""


def nearest(
    queries: Tensor, points: Tensor, count: int, there: Tensor | None = None
) -> tuple[Tensor, Tensor]:
    """The nearest points of every query.

    Args:
        queries: (B, Q, 3) [m].
        points: (B, M, 3) [m].
        count: k, at most M.
        there: (B, M) bool, points that may be found; None is all.

    Returns:
        squared distances (B, Q, k) [m^2], ascending, and indices (B, Q, k).
    """
    # Not the expanded square: float32 would lose millimetres.
    squares = torch.cdist(queries, points, compute_mode="donot_use_mm_for_euclid_dist") ** 2
    if there is not None:
        squares = squares.masked_fill(~there[:, None], FAR)
    found = squares.topk(count, dim=-1, largest=False)
    return found.values, found.indices


def spread(points: Tensor, count: int, there: Tensor) -> Tensor:
    """Farthest-point sampling: indices (B, count) of points far from one another.

    Begins with the first point that is there. With fewer points than ``count`` some repeat.

    Args:
        points: (B, M, 3) [m].
        count: how many.
        there: (B, M) bool, points that may be chosen.
    """
    batch = torch.arange(len(points), device=points.device)
    least = torch.where(there, FAR, -1.0)
    chosen = there.to(torch.int8).argmax(dim=1)
    found = [chosen]
    for _ in range(count - 1):
        offset = points - points[batch, chosen][:, None]
        squares = (offset * offset).sum(-1)
        least = torch.minimum(least, torch.where(there, squares, -1.0))
        chosen = least.argmax(dim=1)
        found.append(chosen)
    return torch.stack(found, dim=1)


def gather(values: Tensor, indices: Tensor) -> Tensor:
    """(B, M, ...) values at (B, ..., k) indices -> (B, ..., k, ...)."""
    first = torch.arange(len(values), device=values.device) * values.shape[1]
    rows = (indices + first.view(-1, *[1] * (indices.ndim - 1))).flatten()
    # index_select's backward pass is many times faster than that of indexing.
    found = values.flatten(0, 1).index_select(0, rows)
    return found.view(*indices.shape, *values.shape[2:])
