"""What the field is trained for: occupancy, direction, distance, and distances between descriptors.

The paper trains occupancy and the direction of the signed distance's gradient. A field of nothing
but these describes a point by its height and distance to the nearest surface, and is useless as a
planning cost: see docs/field.md. So descriptors are also taught how far apart points are.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn import functional

from icd_agent.field.config import FieldConfig
from icd_agent.field.field import FieldOutput

DISTANCE_WEIGHT = 0.3
"""Of the logarithmic distance's error; occupancy and direction have weight 1, as in the paper."""
METRIC_WEIGHT = 0.5
"""Of the error of distances between descriptors."""
SIDE = 0.5
"""How much it matters on which side of a surface a point is: points that touch opposite sides
count as at least this many close scales, times two, apart."""
SMALLEST = 0.02
"""Distances, in close scales, below which errors do not matter."""
NEAR_SURFACE, NEAR_GRADIENT = 0.03, 0.1
"""[m] from surfaces, within which the reported rates count."""


class Truth(NamedTuple):
    """Points (B, Q, 3) [m] with signed distances (B, Q) [m] and gradients (B, Q, 3)."""

    points: Tensor
    distance: Tensor
    gradient: Tensor


def field_loss(
    out: FieldOutput, truth: Truth, pairs: tuple[Tensor, Tensor], config: FieldConfig
) -> dict[str, Tensor]:
    """Terms of the loss of one batch, and two rates to watch.

    Args:
        out: of the field, about ``truth.points``.
        truth: of the same points.
        pairs: indices (P,) of points whose descriptors are compared.
        config: of the field.
    """
    inside = truth.distance < 0
    occupancy = functional.binary_cross_entropy_with_logits(out.occupancy, inside.float())
    direction = (out.gradient - truth.gradient).square().sum(-1).mean()
    log_distance = torch.log1p(truth.distance.abs() / config.close_scale)
    distance = (out.log_distance - log_distance).abs().mean()
    metric = metric_error(out.descriptor / config.length_scale, truth, pairs, config)
    near = truth.distance.abs() < NEAR_SURFACE
    said = out.occupancy > 0
    aligned = functional.cosine_similarity(out.gradient, truth.gradient, dim=-1)
    return {
        "loss": occupancy + direction + DISTANCE_WEIGHT * distance + METRIC_WEIGHT * metric,
        "occupancy": occupancy,
        "direction": direction,
        "distance": distance,
        "metric": metric,
        "iou": (said & inside & near).sum() / ((said | inside) & near).sum().clamp(min=1),
        "cosine": aligned[truth.distance.abs() < NEAR_GRADIENT].mean(),
    }


def metric_error(
    descriptors: Tensor, truth: Truth, pairs: tuple[Tensor, Tensor], config: FieldConfig
) -> Tensor:
    """Mean squared relative error of the distances between descriptors (B, Q, D).

    Args:
        descriptors: in length scales.
        truth: about the same points.
        pairs: indices (P,) of points that are compared.
        config: of the field.
    """
    first, second = pairs
    square = (descriptors[:, first] - descriptors[:, second]).square().sum(-1)
    found = (square + 1e-8).sqrt()  # its root's slope must stay finite
    wanted = contact_distance(truth, pairs, config)
    smallest = SMALLEST * config.close_scale / config.length_scale
    return (torch.log(found + smallest) - torch.log(wanted + smallest)).square().mean()


def contact_distance(truth: Truth, pairs: tuple[Tensor, Tensor], config: FieldConfig) -> Tensor:
    """How far apart points are for contact, (B, P) in length scales.

    The distance-ratio metric log(1 + |x - y| / (s + d)) shrinks distances with the distance d to
    the nearest surface; to it comes, at right angles, the difference of the surface's normals,
    which fades in the same way but within the close scale, so that the two sides of a thin wall
    are apart.
    """
    first, second = pairs
    scale, close = config.length_scale, config.close_scale
    away = truth.distance.abs()
    apart = (truth.points[:, first] - truth.points[:, second]).norm(dim=-1)
    between = torch.log1p(apart / (scale + (away[:, first] + away[:, second]) / 2))
    normal = truth.gradient * (close / (close + away))[..., None]
    side = SIDE * close / scale * (normal[:, first] - normal[:, second]).norm(dim=-1)
    return torch.hypot(between, side)
