"""What ``icd-bench collect`` does: record, then perhaps export, and say what came of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter

from benchmarks.collect import collect
from benchmarks.conditions import parse_options
from benchmarks.console import Values
from benchmarks.executors import Executor
from benchmarks.runner import Watch
from icd_envs.demonstrations import Demonstrations, find_task
from icd_envs.demonstrations.header import Header, shard_path
from icd_envs.errors import InvalidOptionError


def make_header(
    env_id: str, episodes: int, *, seed: int, steps: int | None, options: Sequence[str] = ()
) -> Header:
    """What to record.

    Args:
        env_id: the environment.
        episodes: in all.
        seed: base seed.
        steps: longest episode; None is the task's budget.
        options: of the task, each as ``name=value``.

    Raises:
        InvalidOptionError: unknown environment or option, or more steps than its budget.
    """
    values = dict(parse_options(options))
    budget = find_task(env_id, values).max_steps
    if steps is not None and not 1 <= steps <= budget:
        raise InvalidOptionError(f"steps must be in [1, {budget}] for {env_id}, got {steps}")
    return Header(
        env_id=env_id, options=values, seed=seed, steps=steps or budget, episodes=episodes
    )


def collect_and_export(
    header: Header,
    out: Path,
    executor: Executor,
    *,
    resume: bool,
    minari: str | None,
    watch: Callable[[str], Watch],
) -> Values:
    """Record what is missing, and make a Minari dataset if it has an id.

    Args:
        header: what to record.
        out: folder of the demonstrations.
        executor: who records.
        resume: go on with what is there.
        minari: id of the dataset, or None.
        watch: makes the progress of a part from its label.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: see ``collect`` and ``icd_envs.demonstrations.minari_export``.
    """
    if minari is not None:
        from icd_envs.demonstrations import minari_export

        minari_export.check_dataset_id(minari)
    before = perf_counter()
    rows = collect(header, out, executor, resume=resume, watch=watch("episodes"))
    seconds = perf_counter() - before
    size = sum(shard_path(out, number).stat().st_size for number in range(header.shards))
    values: Values = {
        "episodes": len(rows),
        "steps": sum(row.steps for row in rows),
        "success": sum(row.success for row in rows) / len(rows),
        "diverged": sum(row.diverged for row in rows),
        "megabytes": size / 1e6,
        "seconds": seconds,
    }
    if minari is not None:
        exported = minari_export.export(Demonstrations(out), minari)
        values |= {
            "minari": str(exported.path),
            "minari_episodes": exported.episodes,
            "minari_left_out": exported.left_out,
        }
    return values
