"""Pairs of states of one trajectory, nearer ones more often."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from icd_agent.states import EVERY, States

DISCOUNT: Final = 0.985
"""Per control step: pairs are drawn from the discounted occupancy of the paper."""


class Pairs(NamedTuple):
    """Rows of states, and how many control steps lie between.

    Attributes:
        first: (B,) rows of the earlier states.
        second: (B,) rows of the later ones.
        gap: (B,) control steps.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    gap: NDArray[np.int64]


def draw_pairs(states: States, count: int, rng: np.random.Generator) -> Pairs:
    """Pairs with gaps from a geometric distribution, cut off where the episode ends.

    Args:
        states: of recorded episodes.
        count: B.
        rng: source of every draw.
    """
    first = rng.integers(len(states.step), size=count)
    last = states.first[states.episode[first] + 1] - 1
    gap = rng.geometric(1.0 - DISCOUNT**EVERY, size=count)
    second = np.minimum(first + gap, last)
    return Pairs(first, second, states.step[second] - states.step[first])
