"""What rolling out costs memory and threads; the simulators of one scene share it."""

from __future__ import annotations

import threading

import mujoco
from mujoco import rollout


class RolloutThreads:
    """Threads and one scratch state for each.

    Attributes:
        scratch: states of the scene's sizes; what they hold between rollouts means nothing.
        pool: MuJoCo's threads.
        lock: to be held while either is used, for simulators in several threads of Python.
        closed: whether the threads have been stopped.
    """

    def __init__(self, model: mujoco.MjModel, count: int) -> None:
        """Start the threads.

        Args:
            model: the scene.
            count: threads, at least 1; results do not depend on it.
        """
        self.scratch = [mujoco.MjData(model) for _ in range(count)]
        # With 0 pool threads MuJoCo rolls out on the calling one.
        self.pool = rollout.Rollout(nthread=count if count > 1 else 0)
        self.lock = threading.Lock()
        self.closed = False

    def close(self) -> None:
        """Stop the threads; a second call does nothing."""
        self.closed = True
        self.pool.close()
