"""The buttons, toggles and texts beside the browser's scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from benchmarks.watch.controls import Controls
from benchmarks.watch.session import Moment
from benchmarks.watch.text import NAMES, describe

if TYPE_CHECKING:
    import viser

STEP, BACK, AGAIN, NEXT = "single step", "previous", "same again", "next"
SPEEDS: Final = {
    "0.1 x": 0.1, "0.25 x": 0.25, "0.5 x": 0.5, "1 x": 1.0, "2 x": 2.0, "4 x": 4.0,
    "as fast as it goes": float("inf"),
}  # fmt: skip


class Panel:
    """Tells the controls what a person asks for, and the person what happens."""

    def __init__(
        self,
        gui: viser.GuiApi,
        controls: Controls,
        parts: Mapping[str, bool],
        set_visible: Callable[[str, bool], None],
    ) -> None:
        """Build it.

        Args:
            gui: of a viser server.
            controls: told what is asked for.
            parts: what can be shown, and whether it is.
            set_visible: shows or hides one of them.
        """
        self._controls = controls
        self._episode = 0
        self._play = gui.add_button("pause")
        self._play.on_click(lambda _: self._play_or_pause())
        once = gui.add_button_group("", (STEP, BACK, AGAIN, NEXT))
        once.on_click(lambda _: self._do(once.value))
        speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1 x")
        speed.on_update(lambda _: controls.set_speed(SPEEDS[speed.value]))
        with gui.add_folder("now"):
            self._texts = {name: gui.add_text(name, "", disabled=True) for name in NAMES}
        with gui.add_folder("show"):
            for part, visible in parts.items():
                _add_toggle(gui, part, visible, set_visible)

    def show(self, moment: Moment) -> None:
        """Say what happens now."""
        self._episode = moment.episode
        for name, value in describe(moment).items():
            # viser's setter does not stand beside its getter, where mypy looks for it.
            self._texts[name].value = value  # type: ignore[misc]
        self._name_play_button()

    def _play_or_pause(self) -> None:
        self._controls.play_or_pause()
        self._name_play_button()

    def _do(self, what: str) -> None:
        if what == STEP:
            self._controls.single_step()
            self._name_play_button()
        else:
            by = {BACK: -1, AGAIN: 0, NEXT: 1}[what]
            self._controls.go_to(max(0, self._episode + by))

    def _name_play_button(self) -> None:
        self._play.label = "pause" if self._controls.playing else "play"


def _add_toggle(
    gui: viser.GuiApi, part: str, visible: bool, set_visible: Callable[[str, bool], None]
) -> None:
    box = gui.add_checkbox(part, visible)
    box.on_update(lambda _: set_visible(part, box.value))
