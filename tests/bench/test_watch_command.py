"""``icd-bench watch`` as a person calls it."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from typer.testing import CliRunner

from benchmarks.cli import main
from benchmarks.watch import command
from icd_envs.errors import RenderingUnavailableError
from icd_envs.window import WINDOW_FIX
from tests.bench import toy
from tests.bench.watched import CABLE, Album, Faller, Still, spec

FINE = ["--agent", "random", "--env", CABLE, "--port", "0"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["--agent", "pc-mpi"], "did you mean 'pc-mppi'"),
        (["--agent", "no_such_module:Agent"], "no_such_module"),
        (["--env", "ICDCableRoutin-v0"], "did you mean 'ICDCableRouting"),
        (["--env", toy.ENV], "only this project's environments"),
        (["--port", "65536"], "--port"),
        (["--port", "http"], "--port"),
        (["--viewer", "brouser"], "'browser'"),
        (["--host", "192.0.2.1"], "cannot be listened on"),
        (["--seed", "-1"], "--seed"),
        (["--episode", "-1"], "--episode"),
        (["--option", "goals"], "--option must be name=value"),
        (["--option", "goals=contacts"], "contact"),
    ],
)
def test_usage_errors_exit_2_in_one_line(changes: list[str], message: str) -> None:
    refused = CliRunner().invoke(main, ["watch", *FINE, *changes])
    assert refused.exit_code == 2
    assert message in " ".join(refused.stderr.split())
    assert refused.stdout == ""


def test_agent_that_cannot_be_made_exits_2(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> Still:
        raise OSError("no weights")

    monkeypatch.setattr("tests.bench.watched.broken", broken, raising=False)
    refused = CliRunner().invoke(main, ["watch", *FINE, "--agent", "tests.bench.watched:broken"])
    assert refused.exit_code == 2
    assert "'tests.bench.watched:broken': OSError: no weights" in refused.stderr


def test_port_in_use_exits_2() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        refused = CliRunner().invoke(main, ["watch", *FINE, "--port", port])
    assert refused.exit_code == 2
    assert f"--port {port}" in refused.stderr


def test_missing_viser_exits_2_and_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    refused = CliRunner().invoke(main, ["watch", *FINE])
    assert refused.exit_code == 2
    assert "pip install 'implicit-contact-diffuser[viewer]'" in " ".join(refused.stderr.split())


def test_missing_display_exits_2_and_names_the_fix(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise RenderingUnavailableError(f"no display\n{WINDOW_FIX}")

    monkeypatch.setattr("icd_envs.window.check_display", refuse)
    refused = CliRunner().invoke(main, ["watch", *FINE, "--viewer", "mujoco"])
    assert refused.exit_code == 2
    assert " ".join(WINDOW_FIX.split()) in " ".join(refused.stderr.split())


@pytest.mark.parametrize(("agent", "code"), [(Still, 0), (Faller, 1)])
def test_episode_that_went_wrong_exits_1(
    monkeypatch: pytest.MonkeyPatch, agent: type, code: int
) -> None:
    album = Album(5)
    monkeypatch.setattr(command, "DesktopView", lambda controls: album)
    words = [*FINE, "--agent", spec(agent), "--viewer", "mujoco", "--episode", "3"]
    assert CliRunner().invoke(main, ["watch", *words]).exit_code == code
    assert album.scenes == [3]
    assert album.closed


@contextmanager
def started(*words: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command as a process, and where it says that its page is."""
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks", "watch", *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    try:
        for line in process.stderr:
            if found := re.search(r"watch at (http://\S+)", line):
                yield process, found[1]
                break
        else:
            pytest.fail("no address was told")
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_page_is_there_until_the_program_is_interrupted(number: signal.Signals) -> None:
    with started(*FINE) as (process, address):
        with urllib.request.urlopen(address, timeout=60) as page:
            assert page.status == 200
        process.send_signal(number)
        out, _ = process.communicate(timeout=60)
        assert (process.returncode, out) == (0, "")
