"""The page and its panel, on a real server without a browser."""

from __future__ import annotations

import socket
import sys
import urllib.request
from collections.abc import Iterator
from typing import Any

import pytest

from benchmarks.watch import browser
from benchmarks.watch.browser import BrowserView
from benchmarks.watch.browser_panel import Panel
from benchmarks.watch.controls import Controls
from benchmarks.watch.loop import watch
from benchmarks.watch.session import Session
from icd_envs.errors import InvalidOptionError
from tests.bench.watched import CABLE, Dreamer, spec


@pytest.fixture
def controls() -> Controls:
    return Controls()


@pytest.fixture
def view(controls: Controls) -> Iterator[BrowserView]:
    opened = BrowserView(controls, "<b>name</b>", host="127.0.0.1", port=0)
    yield opened
    opened.close()


def test_page_is_served_on_this_machine_alone(view: BrowserView) -> None:
    assert view.address.startswith("http://127.0.0.1:")
    with urllib.request.urlopen(view.address, timeout=20) as page:
        assert page.status == 200
        assert b"<html" in page.read()


def test_loop_draws_into_a_real_server(view: BrowserView, controls: Controls) -> None:
    session = Session(spec(Dreamer), CABLE)
    seen: list[int] = []

    class Counted:
        """Four looks at the real view."""

        @property
        def is_open(self) -> bool:
            return view.is_open and len(seen) < 4

        def begin(self, env: Any, moment: Any) -> None:  # noqa: ANN401
            view.begin(env, moment)

        def show(self, moment: Any) -> None:  # noqa: ANN401
            view.show(moment)
            seen.append(moment.step)

        close = view.close

    watch(session, Counted(), controls)
    assert seen == [1, 2, 3, 4]
    assert view._panel._texts["plan"].value == "dreaming"
    assert view._panel._texts["step"].value == "4 of 300"
    session.close()


def test_port_in_use_is_refused_instead_of_another_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InvalidOptionError, match=f"--port {port} .*choose another"):
            BrowserView(Controls(), "", host="127.0.0.1", port=port)


def test_address_of_another_machine_is_refused() -> None:
    with pytest.raises(InvalidOptionError, match="cannot be listened on"):
        browser.check_address("192.0.2.1", 0)


def test_without_viser_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InvalidOptionError, match=r"implicit-contact-diffuser\[viewer\]"):
        BrowserView(Controls(), "", host="127.0.0.1", port=0)


class Item:
    """Any element of a panel; ``act`` is what a person does to it."""

    def __init__(self, value: Any = None) -> None:  # noqa: ANN401
        self.value, self.label = value, ""

    def on_click(self, then: Any) -> None:  # noqa: ANN401
        self.then = then

    on_update = on_click

    def act(self, value: object = None) -> None:
        self.value = value
        self.then(None)

    def __enter__(self) -> None: ...

    def __exit__(self, *_: object) -> None: ...


class FakeGui:
    """Keeps a panel's elements, by label."""

    def __init__(self) -> None:
        self.items: dict[str, Item] = {}

    def _add(self, label: str, *values: Any, **more: Any) -> Item:  # noqa: ANN401
        self.items[label] = Item(*values[:1])
        return self.items[label]

    add_button = add_button_group = add_dropdown = add_checkbox = add_text = add_folder = _add


def test_panel_operates_the_controls(controls: Controls) -> None:
    gui: Any = FakeGui()
    toggled: list[tuple[str, bool]] = []
    parts = {"goal": True, "scene cloud": False}
    panel = Panel(gui, controls, parts, lambda part, shown: toggled.append((part, shown)))
    session = Session("random", CABLE)
    panel.show(session.begin(6))
    session.close()
    play, group = gui.items["pause"], gui.items[""]
    assert play.label == "pause"
    play.act()
    assert (controls.playing, play.label) == (False, "play")
    play.act()
    group.act("single step")
    assert (controls.playing, play.label, controls.take_step()) == (False, "play", True)
    for word, episode in (("previous", 5), ("same again", 6), ("next", 7)):
        group.act(word)
        assert controls.take_episode() == episode
    gui.items["speed"].act("0.25 x")
    assert controls.speed == 0.25
    gui.items["scene cloud"].act(True)
    assert toggled == [("scene cloud", True)]
    assert gui.items["step"].value == "0 of 300"


def test_there_is_no_episode_before_the_first(controls: Controls) -> None:
    gui: Any = FakeGui()
    Panel(gui, controls, {}, lambda part, shown: None)
    gui.items[""].act("previous")
    assert controls.take_episode() == 0
