"""Errors of the benchmark, all of them ``IcdError``."""

from __future__ import annotations

import traceback
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


def reason(error: BaseException) -> str:
    """One line: type, text and the place it was raised at."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:500]}{place}"
