"""Errors of the benchmark, all of them ``IcdError``."""

from __future__ import annotations

from icd_envs.errors import IcdError


class ResultsError(IcdError, ValueError):
    """A results folder that cannot be read, written or is already in use."""


class IncompatibleResultsError(ResultsError):
    """Results of another configuration, schema, code or library version."""


class ResultsWarning(UserWarning):
    """Results were readable, but something was left out."""


class WorkerStartError(IcdError, RuntimeError):
    """Worker processes that end before they can do anything."""
