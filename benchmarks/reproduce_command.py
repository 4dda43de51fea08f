"""``icd-bench reproduce``."""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.console import (
    FAILED_EPISODES,
    FINE,
    AsJson,
    TrustPickle,
    errors_in_one_line,
    exit_if,
    import_from_working_directory,
    settle_maths_threads,
)


def reproduce(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Results, e.g. published ones.")],
    episodes: Annotated[
        int, typer.Option(min=1, help="Test cases per agent and task, from the first on.")
    ] = 3,
    device: Annotated[
        str | None, typer.Option(help="Given to agents that ask.", show_default="as it was")
    ] = None,
    trust_pickle: TrustPickle = False,
    workers: Annotated[int, typer.Option(min=0, help="Processes at a time.")] = 1,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the new results.", show_default="runs/<UTC time>")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the results in --out.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Run recorded episodes again and say whether they end as they did."""
    settle_maths_threads(workers)
    import_from_working_directory()
    with errors_in_one_line():
        from benchmarks import progress, results, runner
        from benchmarks.executors import make_executor
        from benchmarks.interrupts import interruptible
        from benchmarks.reproduce import ends_alike, record, recorded
        from benchmarks.run_command import look_first
        from benchmarks.tables import print_pairs

        before = recorded(folder, episodes)
        crew = make_executor("local", workers=workers, threads=None, address=None)
        settings = before.settings(crew.threads, device, trust_pickle=trust_pickle)
        with interruptible() as interrupt, redirect_stdout(sys.stderr):
            told = look_first(before.plan, crew, settings, None)
        exit_if(interrupt)
        results_folder = out or results.new_folder(Path("runs"))
        typer.echo(f"results: {results_folder}", err=True)
        with interruptible() as interrupt, redirect_stdout(sys.stderr):
            found = runner.run(
                before.plan,
                results_folder,
                runner.episodes(settings),
                crew,
                settings=told,
                resume=resume,
                watch=progress.watching("episodes"),
            )
        if interrupt.number:
            typer.echo(f"interrupted; go on with --out '{results_folder}' --resume", err=True)
            raise typer.Exit(interrupt.exit_code)
        pairs, changed = before.pairs(found), before.changed(told)
    if as_json:
        typer.echo(json.dumps(record(pairs, changed)))
    else:
        print_pairs(pairs, changed)
    alike = all(ends_alike(was, now) for was, now in pairs)
    raise typer.Exit(FINE if alike else FAILED_EPISODES)
