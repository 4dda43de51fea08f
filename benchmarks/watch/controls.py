"""What the person watching has asked for; set by any thread, read by the loop."""

from __future__ import annotations

import threading


class Controls:
    """Play, pause, single steps, speed and the choice of an episode."""

    def __init__(self, *, playing: bool = True) -> None:
        """Begin at real speed."""
        self._playing = playing
        self._speed = 1.0
        self._steps = 0
        self._episode: int | None = None
        self._changed = threading.Event()
        self._lock = threading.Lock()

    @property
    def playing(self) -> bool:
        """Whether steps follow one another by themselves."""
        return self._playing

    @property
    def speed(self) -> float:
        """Simulated seconds per second, at most; inf is as fast as agent and machine are."""
        return self._speed

    def play_or_pause(self) -> None:
        """Change from one to the other."""
        with self._lock:
            self._playing = not self._playing
        self._changed.set()

    def single_step(self) -> None:
        """Pause, and take one step."""
        with self._lock:
            self._playing = False
            self._steps += 1
        self._changed.set()

    def set_speed(self, speed: float) -> None:
        """Change the speed, > 0."""
        self._speed = speed
        self._changed.set()

    def go_to(self, episode: int) -> None:
        """Begin an episode, whatever has become of the present one."""
        with self._lock:
            self._episode, self._steps = episode, 0
        self._changed.set()

    def take_episode(self) -> int | None:
        """The episode asked for, once."""
        with self._lock:
            episode, self._episode = self._episode, None
        return episode

    def take_step(self) -> bool:
        """Whether to step now; uses up a single step."""
        with self._lock:
            if self._playing:
                return True
            if self._steps:
                self._steps -= 1
                return True
            return False

    def wait(self, seconds: float) -> None:
        """Wait, but not beyond the next change."""
        self._changed.wait(max(0.0, seconds))
        self._changed.clear()
