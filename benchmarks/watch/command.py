"""What ``icd-bench watch`` does: put session, controls and view together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from typing import Literal

from benchmarks.conditions import parse_options
from benchmarks.interrupts import interruptible
from benchmarks.provenance import cpu_count
from benchmarks.registry import agent_factory
from benchmarks.watch.browser import BrowserView
from benchmarks.watch.controls import Controls
from benchmarks.watch.desktop import DesktopView
from benchmarks.watch.loop import View, watch
from benchmarks.watch.session import Session
from icd_envs.registration import check_env_id

Viewer = Literal["browser", "mujoco"]


def watch_agent(
    agent: str,
    env_id: str,
    *,
    options: Sequence[str] = (),
    seed: int,
    episode: int,
    viewer: Viewer,
    host: str,
    port: int,
    trust_pickle: bool = False,
    say: Callable[[str], None],
) -> int:
    """Watch until the window is closed or the program is interrupted: that is how it ends.

    Args:
        agent: name or ``module:attr``.
        env_id: id of an environment of ours.
        options: of the task, each as ``name=value``.
        seed: base seed, as of ``icd-bench run``.
        episode: the first one.
        viewer: where to draw.
        host: address the browser's view listens on.
        port: of it.
        trust_pickle: whether the agent may be unpickled.
        say: is told where to look.

    Returns:
        Episodes that ended with an error.

    Raises:
        IcdError: whatever is wrong with the options, before anything is opened.
    """
    check_env_id(env_id)
    agent_factory(agent, trust_pickle=trust_pickle)
    controls = Controls()
    session = Session(
        agent, env_id, options=parse_options(options), seed=seed, threads=cpu_count(),
        trust_pickle=trust_pickle,
    )  # fmt: skip
    with closing(session), interruptible():
        view: View
        if viewer == "mujoco":
            view = DesktopView(controls)
        else:
            browser = BrowserView(controls, f"{agent} in {env_id}", host=host, port=port)
            say(f"watch at {browser.address} (end with Ctrl-C)")
            view = browser
        with closing(view):
            watch(session, view, controls, episode)
    return session.errors
