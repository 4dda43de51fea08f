"""What every test relies on."""

from __future__ import annotations

import functools
import ipaddress
import signal
import socket
from collections.abc import Callable, Iterator

import pytest
from hypothesis import settings

from icd_envs.rendering import choose_backend

# A shell that starts the tests in the background ignores SIGINT, and what they start would inherit
# that: the tests that interrupt a run need it to be heard.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Test files may import MuJoCo before any environment does, which would settle for a display.
choose_backend()

settings.register_profile("same examples every time", derandomize=True)
settings.register_profile("new examples every time", derandomize=False)


def pytest_configure(config: pytest.Config) -> None:
    """A default run is the same every time; a long one looks further."""
    new = config.getoption("markexpr") == "slow"
    settings.load_profile("new examples every time" if new else "same examples every time")


class NetworkError(RuntimeError):
    """A test tried to leave this machine."""


@pytest.fixture(scope="session", autouse=True)
def _no_network() -> Iterator[None]:
    """Sockets of this process reach this machine only."""

    def guarded(name: str) -> Callable[[socket.socket, tuple[str, int] | str], object]:
        connect = getattr(socket.socket, name)

        def guard(self: socket.socket, address: tuple[str, int] | str) -> object:
            if self.family in (socket.AF_INET, socket.AF_INET6) and not is_here(address[0]):
                raise NetworkError(f"a test connects to {address}: tests reach this machine only")
            return connect(self, address)

        return guard

    with pytest.MonkeyPatch.context() as patch:
        for name in ("connect", "connect_ex"):
            patch.setattr(socket.socket, name, guarded(name))
        yield


@functools.cache
def is_here(host: str) -> bool:
    """Whether a host is this machine: a loopback address, or its own, by which Ray calls it."""
    if host == "localhost":
        return True
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return False
    family = socket.AF_INET if address.version == 4 else socket.AF_INET6
    with socket.socket(family, socket.SOCK_DGRAM) as own:
        try:
            own.bind((host, 0))  # to another machine's address nothing can be bound
        except OSError:
            return False
    return True
