"""Fill a folder with demonstrations of a scripted expert, shard by shard."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from benchmarks.conditions import DEFAULT, Condition, TaskSpec
from benchmarks.errors import IncompatibleResultsError, ResultsError
from benchmarks.executors import Executor, Retry, Work
from benchmarks.manifest import FILE_NAME as MANIFEST_NAME
from benchmarks.manifest import continued, describe, read_manifest
from benchmarks.plan import Job, Plan
from benchmarks.pulse import Pulse
from benchmarks.results import ROWS_NAME
from benchmarks.rows import Row
from benchmarks.runner import Watch, unwatched
from benchmarks.worker import Loss
from icd_agent.locking import alone
from icd_agent.replacing import write_atomically
from icd_envs.demonstrations import find_task
from icd_envs.demonstrations.header import FILE_NAME, Header, read_header, shard_path
from icd_envs.demonstrations.recording import record
from icd_envs.demonstrations.shard import Arrays, encode, read_shard
from icd_envs.errors import DemonstrationsError

AGENT: Final = "expert-noisy"
"""Name in the manifest; the seeds of its episodes are those of the gate of that name."""


class Shard(NamedTuple):
    """Episodes that go into one file.

    Attributes:
        number: of the file.
        jobs: the episodes.
        repeated: a worker has died of them before.
    """

    number: int
    jobs: list[Job]
    repeated: bool = False


class Recorded(NamedTuple):
    """A shard and what its file will hold."""

    shard: Shard
    content: bytes


def collect(
    header: Header,
    out: Path,
    executor: Executor,
    *,
    resume: bool = True,
    watch: Watch = unwatched,
) -> list[Row]:
    """Record every episode that is not there yet; its bytes depend on the header only.

    Args:
        header: what to record.
        out: the folder.
        executor: who records them.
        resume: go on with episodes that are there; otherwise they are an error.
        watch: shows progress.

    Returns:
        How each episode of the folder ended, in the order of their numbers; without rewards.

    Raises:
        ResultsError: the folder cannot be used, or an episode kills its worker.
        DemonstrationsError: a shard in it is damaged.
        IncompatibleResultsError: it has episodes of another header, code or version.
    """
    condition = DEFAULT
    if header.options:
        name = ", ".join(f"{name}={value}" for name, value in header.options.items())
        condition = Condition(name, tuple(header.options.items()))
    plan = Plan((AGENT,), (TaskSpec(header.env_id, condition),), header.episodes, header.seed)
    jobs = plan.jobs()
    shards = [Shard(k, [jobs[i] for i in header.indices(k)]) for k in range(header.shards)]
    with alone(out, "run", ResultsError):
        _begin(out, header, plan, resume=resume)
        rows, pending = [], []
        for shard in shards:
            finished = _finished(out, shard)
            rows += finished
            if not finished:
                pending.append(shard)
        work = Work(partial(_record, header=header), _lost)
        with (
            watch(len(jobs), tuple(rows)) as seen,
            closing(executor.execute(work, pending)) as recorded,
        ):
            for shard, content in recorded:
                _write(shard_path(out, shard.number), content)
                for row in _finished(out, shard):
                    rows.append(row)
                    seen(row)
    return sorted(rows, key=lambda row: row.index)


def _record(shard: Shard, pulse: Pulse, header: Header) -> Recorded:
    task = find_task(header.env_id, header.options)
    recordings = [
        record(
            task,
            seed=job.seed,
            steps=header.steps,
            split=header.split,
            noisy=header.noisy,
        )
        for job in shard.jobs
    ]
    return Recorded(shard, encode(recordings))


def _lost(shard: Shard, loss: Loss) -> Retry[Shard]:
    if not shard.repeated:
        return Retry(shard._replace(repeated=True))
    seeds = ", ".join(str(job.seed) for job in shard.jobs)
    raise ResultsError(
        f"worker died twice in shard {shard.number}, the second time because: {loss.reason}; "
        f"what is finished is kept; seeds {seeds}"
    )


def _write(path: Path, content: bytes) -> None:
    try:
        write_atomically(path, content)
    except OSError as error:
        raise ResultsError(
            f"cannot write {path}: {error}: free some space or choose another --out, then run the "
            "same command again; what is finished is kept"
        ) from error


def _begin(out: Path, header: Header, plan: Plan, *, resume: bool) -> None:
    manifest = describe(plan)
    if (out / ROWS_NAME).exists():
        raise ResultsError(f"{out} has results of icd-bench run: choose another --out")
    if (out / FILE_NAME).exists():
        if not resume:
            raise ResultsError(f"{out} has demonstrations already: choose another --out")
        _check_same(out, read_header(out), header)
    if (out / MANIFEST_NAME).exists():
        manifest = continued(read_manifest(out), manifest)
    _write(out / MANIFEST_NAME, manifest.to_json())
    _write(out / FILE_NAME, header.to_json())


def _check_same(out: Path, old: Header, new: Header) -> None:
    differences = [
        f"{name}: {before!r} there, {getattr(new, name)!r} now"
        for name, before in vars(old).items()
        if name != "episodes" and before != getattr(new, name)
    ]
    if differences:
        raise IncompatibleResultsError(
            f"cannot go on with {out}: {'; '.join(differences)}: choose another --out"
        )


def _finished(out: Path, shard: Shard) -> list[Row]:
    """Rows of a shard that is there, whole; none if it must be recorded."""
    path = shard_path(out, shard.number)
    if not path.exists():
        return []
    arrays = read_shard(path)
    seeds = [job.seed for job in shard.jobs]
    if arrays["seeds"].tolist() != seeds[: len(arrays["seeds"])]:
        raise DemonstrationsError(f"{path} has other episodes: delete it and collect again")
    return _rows(shard.jobs, arrays) if len(arrays["seeds"]) == len(seeds) else []


def _rows(jobs: Sequence[Job], arrays: Arrays) -> list[Row]:
    ends = (arrays["lengths"] + 1).cumsum() - 1
    return [
        Row(
            agent=job.agent,
            env=job.env,
            index=job.index,
            seed=job.seed,
            condition=job.condition.name,
            status="ok",
            success=bool(arrays["success"][i]),
            complete=0.0 if arrays["diverged"][i] else float(arrays["solved"][ends[i]].mean()),
            steps=int(arrays["lengths"][i]),
            return_=0.0,
            diverged=bool(arrays["diverged"][i]),
            message="",
            seconds=0.0,
            act_seconds=0.0,
            privileged="oracle",
        )
        for i, job in enumerate(jobs)
    ]
