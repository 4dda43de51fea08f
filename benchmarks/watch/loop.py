"""Between a session, its controls and a view: who does what when."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any, Final, Protocol

from benchmarks.watch.controls import Controls
from benchmarks.watch.session import Moment, Session
from icd_envs.screen import CONTROL_PERIOD
from icd_envs.tasks.env import ContactEnv

IDLE_SECONDS: Final = 0.2
"""How often a view that was paused is asked whether it is still open."""


class View(Protocol):
    """Something that draws moments."""

    @property
    def is_open(self) -> bool:
        """Whether anybody could still look."""
        ...

    def begin(self, env: ContactEnv[Any], moment: Moment) -> None:
        """Draw a new scene and its first moment."""
        ...

    def show(self, moment: Moment) -> None:
        """Draw a moment of the same scene."""
        ...

    def close(self) -> None:
        """Free what was opened; a second call does nothing."""
        ...


def watch(
    session: Session,
    view: View,
    controls: Controls,
    first: int = 0,
    clock: Callable[[], float] = perf_counter,
) -> None:
    """Step and draw as the controls say, until the view is closed.

    Args:
        session: what is watched.
        view: where.
        controls: of the person watching.
        first: episode to begin with.
        clock: [s]; steps come no faster than the controls' speed by it.
    """
    moment = session.begin(first)
    view.begin(session.env, moment)
    while view.is_open:
        start = clock()
        episode = controls.take_episode()
        if episode is not None:
            moment = session.begin(episode)
            view.begin(session.env, moment)
        elif not moment.end and controls.take_step():
            moment = session.advance()
            view.show(moment)
            controls.wait(start + CONTROL_PERIOD / controls.speed - clock())
        else:
            controls.wait(IDLE_SECONDS)
