"""A view in the browser, served by viser on this machine."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from benchmarks.watch.browser_panel import Panel
from benchmarks.watch.browser_scene import PARTS, BrowserScene
from benchmarks.watch.controls import Controls
from benchmarks.watch.session import Moment
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.env import ContactEnv

FARTHER: Final = 0.2
"""[m] behind the camera of pictures: the panel hides a part of the page."""


def check_viser() -> None:
    """Make sure that the browser's view can be served.

    Raises:
        InvalidOptionError: if viser is not installed.
    """
    try:
        import viser  # noqa: F401
    except ImportError as error:
        raise InvalidOptionError(
            f"--viewer browser needs viser ({error}): "
            "pip install 'implicit-contact-diffuser[viewer]'"
        ) from error


def check_address(host: str, port: int) -> None:
    """Make sure that a server can listen there; viser would look for another port by itself.

    Raises:
        InvalidOptionError: if it cannot.
    """
    import socket

    try:
        with socket.create_server((host, port)):
            pass
    except OSError as error:
        raise InvalidOptionError(
            f"--host {host} --port {port} cannot be listened on ({error.strerror}): choose another "
            "port, 0 for any that is free"
        ) from error


class BrowserView:
    """A web server; whoever opens its page sees the scene and has the controls."""

    is_open = True  # nobody can close a server but the person who started it

    def __init__(self, controls: Controls, title: str, *, host: str, port: int) -> None:
        """Start serving.

        Args:
            controls: to be operated from the page.
            title: names agent and environment.
            host: address to listen on.
            port: 0 for any that is free.

        Raises:
            InvalidOptionError: if viser is missing, or the address cannot be listened on.
        """
        check_viser()
        check_address(host, port)
        import viser

        self._server = viser.ViserServer(host, port, label=title, verbose=False)
        # Sharing would open a tunnel through a server of somebody else.
        self._server.gui.configure_theme(show_logo=False, show_share_button=False)
        self._server.gui.main_panel.dock_right()
        self._scene = BrowserScene(self._server)
        self._panel = Panel(self._server.gui, controls, PARTS, self._scene.set_visible)

    @property
    def address(self) -> str:
        """Of the page."""
        return f"http://{self._server.get_host()}:{self._server.get_port()}"

    def begin(self, env: ContactEnv[Any], moment: Moment) -> None:
        """Draw a new scene; the first one also sets where a page's camera begins."""
        self._scene.begin(env, moment)
        camera = env.model.camera("overview")
        forward = -camera.mat0.reshape(3, 3)[:, 2]
        start = self._server.initial_camera
        start.fov = np.radians(camera.fovy[0])
        start.position = camera.pos - FARTHER * forward
        clouds = [moment.observation["achieved_goal"], moment.observation["desired_goal"]]
        start.look_at = np.concatenate(clouds).mean(axis=0)
        self._panel.show(moment)

    def show(self, moment: Moment) -> None:
        """Draw a moment of the same scene."""
        self._scene.draw(moment)
        self._panel.show(moment)

    def close(self) -> None:
        """Stop serving."""
        self._server.stop()
