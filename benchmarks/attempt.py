"""What a worker is told to play, and what it answers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from benchmarks.plan import Job
from benchmarks.rows import Row
from benchmarks.worker import MATH_THREADS, maths_threads
from icd_envs.errors import InvalidOptionError

RENDERING: Final = "rendering"
"""What a worker is doing while it draws a picture."""


class Attempt(NamedTuple):
    """One go at an episode.

    Attributes:
        job: the episode.
        film: make a video of it.
    """

    job: Job
    film: bool = False


class Played(NamedTuple):
    """How it went.

    Attributes:
        row: of the results.
        video: content of an mp4 file, empty if none was made.
    """

    row: Row
    video: bytes = b""


@dataclass(frozen=True)
class Settings:
    """What an agent is given beside its episode.

    Attributes:
        threads: for its simulator; results do not depend on it.
        act_seconds: [s] that one ``act`` may take.
        episode_seconds: [s] that one episode may take, with everything that must be loaded for it.
        device: for factories that ask for one.
        trust_pickle: whether agents may be unpickled, which runs whatever code is in the file.
        render_seconds: [s] that one picture of a video may take.
    """

    threads: int = 1
    act_seconds: float = 60.0
    episode_seconds: float = 3600.0
    device: str = "cpu"
    trust_pickle: bool = False
    render_seconds: float = 60.0

    def __post_init__(self) -> None:
        """Refuse budgets that nothing could keep."""
        for name in ("act_seconds", "episode_seconds", "render_seconds"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise InvalidOptionError(f"{name} must be positive and finite, got {value!r}")

    def record(self) -> dict[str, str | float]:
        """What decides how an episode ends; a run goes on only with the same."""
        return {
            "act_seconds": self.act_seconds,
            "episode_seconds": self.episode_seconds,
            "device": self.device,
            MATH_THREADS: maths_threads(),
        }
