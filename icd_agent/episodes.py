"""Which recorded episodes are learned from, and whose ends are their goals."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError

FOREIGN: Final = 0.4
"""Share of goals that are of another scene, with the same parts of the task done."""


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


class Goals:
    """Whose last state is an episode's goal: its own, or that of one like it in another scene."""

    def __init__(self, solved: NDArray[np.bool_]) -> None:
        """Find out which episodes are alike.

        Args:
            solved: (E, F) which parts of the task each has done in the end.
        """
        _, kind = np.unique(solved, axis=0, return_inverse=True)
        kinds = [np.flatnonzero(kind == each) for each in range(kind.max() + 1)]
        self._alike = [kinds[each] for each in kind]

    def draw(
        self,
        episodes: NDArray[np.int64],
        rng: np.random.Generator,
        at_end: NDArray[np.bool_] | bool = True,
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Draw goals.

        Args:
            episodes: (B,) indices.
            rng: source of every draw.
            at_end: (B,) whether the goal is the episode's last state; one on the way has no
                counterpart elsewhere.

        Returns:
            (B,) indices of the episodes, and whether they are others.
        """
        foreign, share = rng.random(len(episodes)) < FOREIGN, rng.random(len(episodes))
        foreign = foreign & at_end
        goals = episodes.copy()
        for i in np.flatnonzero(foreign):
            like = self._alike[episodes[i]]
            goals[i] = like[int(share[i] * len(like))]
        return goals, foreign
