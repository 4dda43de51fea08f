"""What all commands share: exit codes, options, and how errors are said. Imports nothing heavy."""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from benchmarks.interrupts import Interrupt

FINE, FAILED_EPISODES, USAGE, INCOMPATIBLE = 0, 1, 2, 3

Values = dict[str, int | float | str | None]
"""What a command found out, by name."""

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, and only JSON, on stdout.")]
TrustPickle = Annotated[
    bool, typer.Option("--trust-pickle", help="Load sb3: files, which may run any code.")
]
TaskOptions = Annotated[
    list[str] | None,
    typer.Option(
        "--option", metavar="NAME=VALUE", help="Of the task, e.g. goals=contact; repeatable."
    ),
]


def exit_if(interrupt: Interrupt) -> None:
    """Exit if a signal came to a command that goes on where it was."""
    if interrupt.number:
        typer.echo("interrupted; the same command goes on", err=True)
        raise typer.Exit(interrupt.exit_code)


@contextmanager
def errors_in_one_line() -> Iterator[None]:
    """Say what our errors and warnings say, without a traceback, and exit as documented."""
    from benchmarks.errors import IncompatibleResultsError
    from icd_envs.errors import IcdError

    warnings.formatwarning = lambda message, *_: f"icd-bench: warning: {message}\n"
    try:
        yield
    except IcdError as error:
        typer.echo(f"icd-bench: {' '.join(str(error).split())}", err=True)
        code = INCOMPATIBLE if isinstance(error, IncompatibleResultsError) else USAGE
        raise typer.Exit(code) from None


def say(values: Mapping[str, int | float | str | None], as_json: bool) -> None:
    """Print what a command found."""
    if as_json:
        typer.echo(json.dumps(dict(values)))
        return
    from benchmarks.tables import print_values

    print_values(values)


def settle_maths_threads(workers: int | None) -> None:
    """Let linear algebra in this process have the threads it has in a worker, if all is done here.

    Call it before anything loads NumPy, which looks only then.
    """
    from benchmarks.worker import MATH_THREADS, maths_threads

    if workers == 0:
        os.environ.setdefault(MATH_THREADS, maths_threads())


def import_from_working_directory() -> None:
    """Let ``module:attr`` name a file beside the user; installed packages come first."""
    if os.getcwd() not in sys.path and "" not in sys.path:
        sys.path.append(os.getcwd())
