"""The generators that are nobody's: Python's, NumPy's and PyTorch's.

Our own code never draws from them. An agent may; seeding them for every episode makes it
reproducible all the same, whatever was played before in the same process.
"""

from __future__ import annotations

import random
import sys

import numpy as np


def seed_global_generators(seed: int) -> None:
    """Seed all of them that are in use.

    Args:
        seed: in [0, 2**32).
    """
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002  for agents that draw from it
    if torch := sys.modules.get("torch"):
        torch.manual_seed(seed)
