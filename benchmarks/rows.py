"""One episode, one row, one line of JSON."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Literal

from benchmarks.plan import Job, JobKey
from benchmarks.schema import SCHEMA, upgraded_row

PRIVILEGES = ("", "simulator", "oracle", "simulator+oracle", "unspecified")
"""What an agent can be given beyond observations; schema 1 did not say which it was."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """How one episode ended.

    Attributes:
        schema: version of these fields.
        agent: name of the agent.
        env: id of the environment.
        condition: name of the condition, "default" for the environment as it is.
        index: number of the test case.
        repeat: number of the episode of this agent on this case; more than 0 only in suites
            that meet every case several times, with the same scene and another seed of the agent.
        seed: seed of the scene; that of the agent is ``benchmarks.suites.agent_seed`` of it.
        status: "error" when the episode could not be finished; such rows count in no rate.
        success: ``is_success`` at the end.
        complete: ``complete_rate`` at the end, in [0, 1].
        steps: control steps taken; a success ends an episode.
        return_: sum of the rewards.
        diverged: the physics blew up.
        buffer_overflows: how often a contact or constraint buffer was full; None if not counted.
        message: why the status is "error", else empty.
        seconds: [s] wall time of the whole episode.
        act_seconds: [s] mean wall time of one ``act``.
        privileged: what the agent was given beyond observations, one of ``PRIVILEGES``: the
            simulator, the expert's solution (oracle), or both; empty for nothing.
    """

    schema: int = SCHEMA
    agent: str
    env: str
    condition: str = "default"
    index: int
    repeat: int = 0
    seed: int
    status: Literal["ok", "error"]
    success: bool
    complete: float
    steps: int
    return_: float
    diverged: bool
    buffer_overflows: int | None = None
    message: str
    seconds: float
    act_seconds: float
    privileged: str

    def __post_init__(self) -> None:
        """Refuse values of a wrong type or range, so that no bad number reaches a table."""
        for name, value in vars(self).items():
            if name == "buffer_overflows" and value is None:
                continue
            kind = _KINDS[name]
            fits = type(value) is kind or (kind is float and type(value) is int)
            if not fits or (kind is float and not math.isfinite(value)):
                raise ValueError(f"{name} must be a finite {kind.__name__}, got {value!r}")
            if name in _COUNTS and value < 0:
                raise ValueError(f"{name} must be >= 0, got {value!r}")
        if self.status not in ("ok", "error"):
            raise ValueError(f"status must be 'ok' or 'error', got {self.status!r}")
        if self.privileged not in PRIVILEGES:
            raise ValueError(f"privileged must be one of {PRIVILEGES}, got {self.privileged!r}")
        if not 0.0 <= self.complete <= 1.0:
            raise ValueError(f"complete must be in [0, 1], got {self.complete!r}")

    @property
    def key(self) -> JobKey:
        """Key of the job this row answers."""
        return (self.agent, self.env, self.condition, self.index, self.repeat)

    def without_times(self) -> Row:
        """The part that another run of the same episode must reproduce."""
        return replace(self, seconds=0.0, act_seconds=0.0)

    @property
    def outcome(self) -> tuple[str, bool, float, int, float, bool]:
        """What happened, in the fields that every schema has."""
        return (
            self.status, self.success, self.complete, self.steps, self.return_, self.diverged
        )  # fmt: skip

    def to_line(self) -> str:
        """One line of JSON, newline included."""
        return json.dumps(vars(self), allow_nan=False) + "\n"


_KINDS: dict[str, type] = {
    **dict.fromkeys(("agent", "env", "condition", "status", "message", "privileged"), str),
    **dict.fromkeys(("schema", "index", "repeat", "seed", "steps", "buffer_overflows"), int),
    **dict.fromkeys(("success", "diverged"), bool),
    **dict.fromkeys(("complete", "return_", "seconds", "act_seconds"), float),
}


_COUNTS = ("index", "repeat", "seed", "steps", "buffer_overflows", "seconds", "act_seconds")


def row_from_record(record: object) -> Row:
    """Check a parsed line, of this schema or an older one, and make a row of it.

    Raises:
        ValueError: not a row; the message names the field.
    """
    if not isinstance(record, dict):
        raise ValueError(f"expected a JSON object, got {type(record).__name__}")
    record = upgraded_row(record)
    if wrong := set(_KINDS) ^ set(record):
        raise ValueError(f"missing or unknown fields: {', '.join(sorted(map(str, wrong)))}")
    return Row(**record)


def error_row(
    job: Job,
    message: str,
    *,
    steps: int = 0,
    return_: float = 0.0,
    seconds: float = 0.0,
    act_seconds: float = 0.0,
    privileged: str = "",
) -> Row:
    """Row of an episode that could not be finished."""
    return Row(
        agent=job.agent,
        env=job.env,
        condition=job.condition.name,
        index=job.index,
        repeat=job.repeat,
        seed=job.seed,
        status="error",
        success=False,
        complete=0.0,
        steps=steps,
        return_=return_ if math.isfinite(return_) else 0.0,
        diverged=False,
        message=message,
        seconds=seconds,
        act_seconds=act_seconds,
        privileged=privileged,
    )
