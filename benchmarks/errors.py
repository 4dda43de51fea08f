"""Errors of the benchmark, all of them ``IcdError``."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from icd_envs.errors import IcdError


class ResultsError(IcdError, ValueError):
    """A results folder that cannot be read, written or is already in use."""


class IncompatibleResultsError(ResultsError):
    """Results of another configuration, schema, code or library version."""


class ResultsWarning(UserWarning):
    """Results were readable, but something was left out."""


class WorkerStartError(IcdError, RuntimeError):
    """Worker processes that end before they can do anything."""


class AgentFailedError(IcdError, RuntimeError):
    """An agent that raised where there is no row to say so."""


@contextmanager
def blaming(agent: str) -> Iterator[None]:
    """Say in one line what an agent raises.

    Raises:
        AgentFailedError: it raised, or left the program.
    """
    try:
        yield
    except IcdError:
        raise
    except (Exception, SystemExit) as error:
        raise AgentFailedError(f"agent {agent!r}: {reason(error)}") from error


def reason(error: BaseException) -> str:
    """One line: type, text and the place it was raised at."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:500]}{place}"
