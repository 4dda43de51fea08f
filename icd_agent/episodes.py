"""Which recorded episodes are learned from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError


def sound_episodes(demonstrations: Demonstrations, episodes: int) -> NDArray[np.int64]:
    """Those of the first so many whose physics did not blow up: their ends are no states to reach.

    Args:
        demonstrations: recorded.
        episodes: how many are looked at, at most.

    Returns:
        (E,) their indices.

    Raises:
        DemonstrationsError: all diverged.
    """
    looked_at = min(episodes, len(demonstrations))
    found = np.flatnonzero(~np.asarray(demonstrations.diverged[:looked_at], bool))
    if len(found) == 0:
        raise DemonstrationsError(
            f"the physics diverged in all of the first {looked_at} episodes: use more of them, or "
            "collect others"
        )
    return found
