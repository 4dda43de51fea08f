"""The command ``icd-bench``.

Heavy imports happen inside the commands, so that help is quick; what agents print goes to stderr,
so that stdout holds the table or JSON alone.
"""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated, Literal

import typer

from benchmarks import baseline_commands, network_commands, reproduce_command
from benchmarks.console import (
    FAILED_EPISODES,
    FINE,
    AsJson,
    TaskOptions,
    TrustPickle,
    errors_in_one_line,
    exit_if,
    import_from_working_directory,
    say,
    settle_maths_threads,
)

main = typer.Typer(
    help="Run agents on the Implicit Contact Diffuser tasks and print honest tables.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
baseline_commands.offer(network_commands.GROUPS["train"])
for name, group in network_commands.GROUPS.items():
    main.add_typer(group, name=name)
main.command()(reproduce_command.reproduce)

Workers = Annotated[
    int | None,
    typer.Option(
        min=0,
        help="Processes at a time; 0: all in this one, for debuggers.",
        show_default="1; on a cluster, as many as it has cores for",
    ),
]
Executor = Annotated[str, typer.Option(help="local, or ray.")]
Address = Annotated[
    str | None,
    typer.Option(help="Ray cluster, host:port or auto.", show_default="RAY_ADDRESS, or a new one"),
]
Threads = Annotated[
    int | None,
    typer.Option(min=1, help="Planner threads of a worker.", show_default="cores / workers"),
]
ActSeconds = Annotated[float, typer.Option(help="Time that one act may take.")]
Device = Annotated[str, typer.Option(help="Given to agents that ask for one.")]


Videos = Literal["first", "failures", "all"]
"""Which videos are made, or shown by a page."""


@main.command(name="list")
def list_() -> None:
    """List agents, plug-ins, environments, suites and gates."""
    import_from_working_directory()
    with errors_in_one_line():
        from benchmarks.listing import entries
        from benchmarks.tables import print_rows

        print_rows(("kind", "name", "what"), list(entries()))


@main.command()
def run(
    agent: Annotated[list[str], typer.Option(help="As icd-bench list shows; repeatable.")],
    env: Annotated[
        list[str] | None,
        typer.Option(help="Environment id; repeatable; of the suite's, or another."),
    ] = None,
    suite: Annotated[
        str | None, typer.Option(help="Fixed environments and episodes.", show_default="quick")
    ] = None,
    condition: Annotated[
        list[str] | None,
        typer.Option(help="Only tasks of the suite under it; repeatable.", show_default="all"),
    ] = None,
    episodes: Annotated[
        int | None,
        typer.Option(min=1, help="Test cases per agent and task, instead of the suite's."),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            min=0, help="Base seed of all episodes.", show_default="the suite's, mostly 0"
        ),
    ] = None,
    act_seconds: ActSeconds = 60.0,
    episode_seconds: Annotated[
        float, typer.Option(help="Time that one episode may take, loading included.")
    ] = 3600.0,
    device: Device = "cpu",
    trust_pickle: TrustPickle = False,
    workers: Workers = None,
    threads: Threads = None,
    executor: Executor = "local",
    address: Address = None,
    out: Annotated[
        Path | None, typer.Option(help="Results folder.", show_default="runs/<UTC time>")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the results in --out.")
    ] = False,
    allow_mixed: Annotated[
        bool,
        typer.Option("--allow-mixed", help="Resume with other budgets, code or versions; flagged."),
    ] = False,
    retry_errors: Annotated[
        bool, typer.Option("--retry-errors", help="Resume, and run errors again; flagged.")
    ] = False,
    videos: Annotated[
        Videos | None, typer.Option(help="Episodes to film.", show_default="none")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run agents, one row per episode, and print the table."""
    settle_maths_threads(workers)
    import_from_working_directory()
    with errors_in_one_line():
        from benchmarks import progress, results, runner
        from benchmarks.attempt import Settings
        from benchmarks.executors import make_executor
        from benchmarks.interrupts import interruptible
        from benchmarks.plan import plan_suite
        from benchmarks.run_command import look_first
        from benchmarks.suites import find_suite
        from icd_envs.errors import InvalidOptionError

        chosen = find_suite(suite or "quick")
        plan = plan_suite(
            chosen,
            agent,
            envs=env or (),
            conditions=condition or (),
            episodes=episodes,
            seed=seed,
        )
        if (resume or retry_errors) and out is None:
            raise InvalidOptionError("to resume needs --out: name the folder to go on with")
        crew = make_executor(executor, workers=workers, threads=threads, address=address)
        settings = Settings(crew.threads, act_seconds, episode_seconds, device, trust_pickle)
        with interruptible() as interrupt, redirect_stdout(sys.stderr):
            record = look_first(plan, crew, settings, videos)
        exit_if(interrupt)
        folder = out or results.new_folder(Path("runs"))
        typer.echo(f"results: {folder}", err=True)
        with interruptible() as interrupt, redirect_stdout(sys.stderr):
            runner.run(
                plan,
                folder,
                runner.episodes(settings),
                crew,
                settings=record,
                videos=videos,
                resume=resume or retry_errors,
                allow_mixed=allow_mixed,
                retry_errors=retry_errors,
                watch=progress.watching("episodes"),
            )
        if interrupt.number:
            typer.echo(f"interrupted; go on with --out '{folder}' --resume", err=True)
        from benchmarks.report_command import report as print_report

        errors = print_report([folder], "json" if as_json else "table")
    if interrupt.number:
        raise typer.Exit(interrupt.exit_code)
    raise typer.Exit(FAILED_EPISODES if errors else FINE)


@main.command()
def check_agent(
    agent: Annotated[str, typer.Argument(metavar="AGENT", help="As icd-bench list shows.")],
    env: Annotated[str, typer.Option(help="Environment id.")] = "ICDCableRouting-v0",
    act_seconds: ActSeconds = 60.0,
    device: Device = "cpu",
    trust_pickle: TrustPickle = False,
    as_json: AsJson = False,
) -> None:
    """Play a few steps with an agent and say what it does wrong."""
    import_from_working_directory()
    with errors_in_one_line():
        from benchmarks import agent_check
        from benchmarks.attempt import Settings
        from benchmarks.executors import Local
        from benchmarks.tables import print_rows
        from icd_envs.registration import check_env_id

        check_env_id(env)
        executor = Local()
        settings = Settings(executor.threads, act_seconds, device=device, trust_pickle=trust_pickle)
        findings = agent_check.check_agent(agent, env, executor, settings)
    if as_json:
        typer.echo(json.dumps(dict(findings)))
    else:
        rows = [(check, f"WRONG: {problem}" if problem else "ok") for check, problem in findings]
        print_rows(("check", agent), rows)
    raise typer.Exit(FAILED_EPISODES if any(finding.problem for finding in findings) else FINE)


@main.command()
def report(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Results folders.")],
    as_json: AsJson = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print Markdown tables.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX tables.")] = False,
    html: Annotated[Path | None, typer.Option(help="File for a page with everything.")] = None,
    csv: Annotated[Path | None, typer.Option(help="File for all rows.")] = None,
    videos: Annotated[Videos, typer.Option(help="Videos that the page shows.")] = "all",
    video_megabytes: Annotated[
        float, typer.Option(min=0, help="Most of them that the page may hold.")
    ] = 25.0,
) -> None:
    """Print the table of results folders, or write a page about them."""
    if as_json + markdown + latex > 1:
        raise typer.BadParameter("--json, --markdown and --latex: choose one")
    form: Literal["table", "json", "markdown", "latex"] = (
        "json" if as_json else "markdown" if markdown else "latex" if latex else "table"
    )
    with errors_in_one_line():
        from benchmarks.report_command import report as print_report

        print_report(folders, form, html=html, csv=csv, videos=videos, megabytes=video_megabytes)


@main.command()
def gates(
    env: Annotated[str, typer.Option(help="Environment id.")],
    only: Annotated[list[str] | None, typer.Option(help="Gate; repeatable.")] = None,
    workers: Workers = None,
    threads: Threads = None,
    out: Annotated[
        Path | None, typer.Option(help="Results folder.", show_default="runs/gates-<env>")
    ] = None,
    resume: Annotated[bool, typer.Option(help="Go on with the results in --out.")] = True,
    as_json: AsJson = False,
) -> None:
    """Check that a task is neither too easy nor too hard."""
    with errors_in_one_line():
        from benchmarks import progress
        from benchmarks.executors import make_executor
        from benchmarks.gates import gates_of, run_gates
        from benchmarks.interrupts import interruptible
        from benchmarks.tables import print_verdicts

        chosen = gates_of(env, only or ())
        folder = out or Path("runs") / f"gates-{env}"
        typer.echo(f"results: {folder}", err=True)
        executor = make_executor("local", workers=workers, threads=threads, address=None)
        with interruptible() as interrupt, redirect_stdout(sys.stderr):
            verdicts = run_gates(
                env, chosen, folder, executor, resume=resume, watch=progress.watching
            )
        exit_if(interrupt)
    if as_json:
        typer.echo(json.dumps({name: verdict.record() for name, verdict in verdicts.items()}))
    else:
        print_verdicts(chosen, verdicts)
    raise typer.Exit(FINE if all(v.ok for v in verdicts.values()) else FAILED_EPISODES)


@main.command()
def collect(
    env: Annotated[str, typer.Option(help="Environment id.")],
    episodes: Annotated[int, typer.Option(min=1, help="Episodes in all.")],
    out: Annotated[Path, typer.Option(help="Folder of the demonstrations.")],
    workers: Workers = None,
    executor: Executor = "local",
    address: Address = None,
    seed: Annotated[int, typer.Option(min=0, help="Base seed of all episodes.")] = 0,
    steps: Annotated[
        int | None,
        typer.Option(min=1, help="Longest episode.", show_default="the environment's budget"),
    ] = None,
    options: TaskOptions = None,
    resume: Annotated[bool, typer.Option(help="Go on with what is in --out.")] = True,
    minari: Annotated[
        str | None, typer.Option(metavar="ID", help="Then make a Minari dataset of this id.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Record episodes of the noisy expert in training scenes."""
    import_from_working_directory()
    with errors_in_one_line():
        from benchmarks import collect_command, progress
        from benchmarks.executors import make_executor
        from benchmarks.interrupts import interruptible

        crew = make_executor(executor, workers=workers, threads=1, address=address)
        with interruptible() as interrupt, redirect_stdout(sys.stderr):
            values = collect_command.collect_and_export(
                collect_command.make_header(
                    env, episodes, seed=seed, steps=steps, options=options or ()
                ),
                out,
                crew,
                resume=resume,
                minari=minari,
                watch=progress.watching,
            )
        exit_if(interrupt)
        say(values, as_json)


@main.command(name="export-scene")
def export_scene(
    env: Annotated[str, typer.Option(help="Environment id.")],
    out: Annotated[Path, typer.Option(help="File to write; ends in .glb.")],
    seed: Annotated[int, typer.Option(min=0, help="Of the scene, as for reset.")] = 0,
    split: Annotated[str, typer.Option(help="train or test.")] = "train",
    as_json: AsJson = False,
) -> None:
    """Write a scene at its start as a mesh file (glTF) for papers, slides and web pages."""
    with errors_in_one_line():
        from benchmarks import export_command

        say(export_command.export_scene(env, out, seed=seed, split=split), as_json)


@main.command()
def watch(
    agent: Annotated[str, typer.Option(help="Agent, as icd-bench run takes it.")],
    env: Annotated[str, typer.Option(help="Environment id.")],
    options: TaskOptions = None,
    trust_pickle: TrustPickle = False,
    seed: Annotated[int, typer.Option(min=0, help="Base seed of all episodes, as of run.")] = 0,
    episode: Annotated[int, typer.Option(min=0, help="Index of the first episode.")] = 0,
    viewer: Annotated[
        Literal["browser", "mujoco"], typer.Option(help="A page to open, or a desktop window.")
    ] = "browser",
    host: Annotated[str, typer.Option(help="Address the page is served on.")] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port of it; 0 is any that is free.")
    ] = 8080,
) -> None:
    """Look at an agent while it acts: clouds, subgoals and plans."""
    import_from_working_directory()
    with errors_in_one_line(), redirect_stdout(sys.stderr):
        from benchmarks.watch.command import watch_agent

        errors = watch_agent(
            agent, env, options=options or (), seed=seed, episode=episode, viewer=viewer, host=host,
            port=port, trust_pickle=trust_pickle, say=lambda text: typer.echo(text, err=True),
        )  # fmt: skip
    raise typer.Exit(FAILED_EPISODES if errors else FINE)


@main.command()
def perf(
    repeats: Annotated[int, typer.Option(min=1, help="Interleaved repeats; medians.")] = 5,
    as_json: AsJson = False,
) -> None:
    """Measure physics and planner on this machine."""
    with errors_in_one_line():
        from benchmarks.perf.report import measure

        say(measure(repeats), as_json)
