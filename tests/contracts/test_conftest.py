"""What ``tests.conftest`` promises: no test leaves the machine, and every run is the same."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

ELSEWHERE = [
    (socket.AF_INET, ("198.51.100.1", 80)),  # reserved for documentation, as the next
    (socket.AF_INET6, ("2001:db8::1", 80)),
    (socket.AF_INET, ("example.org", 80)),
]


@pytest.mark.parametrize("call", ["connect", "connect_ex"])
@pytest.mark.parametrize(("family", "address"), ELSEWHERE)
def test_tests_reach_no_other_machine(
    family: socket.AddressFamily, address: tuple[str, int], call: str
) -> None:
    with socket.socket(family) as client:
        client.settimeout(0.1)
        with pytest.raises(RuntimeError, match=f"{address[0]}.*tests reach this machine only"):
            getattr(client, call)(address)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_tests_reach_this_machine(host: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with socket.socket() as client:
            client.connect((host, port))
            assert client.getpeername() == ("127.0.0.1", port)


def test_tests_reach_sockets_that_are_files(tmp_path: Path) -> None:
    path = str(tmp_path / "socket")
    with socket.socket(socket.AF_UNIX) as server, socket.socket(socket.AF_UNIX) as client:
        server.bind(path)
        server.listen()
        client.connect(path)
        assert client.getpeername() == path


def examples() -> list[int]:
    """What Hypothesis draws when nothing is said of how."""
    drawn: list[int] = []

    @settings(max_examples=20, database=None)
    @given(st.integers())
    def draw(number: int) -> None:
        drawn.append(number)

    draw()
    return drawn


def test_default_runs_draw_the_same_examples_every_time() -> None:
    first = examples()
    assert len(set(first)) > 5
    assert examples() == first
