"""One episode, one row, one line of JSON."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, replace
from typing import Literal

from benchmarks.plan import Job, JobKey

SCHEMA = 1


@dataclass(frozen=True, kw_only=True)
class Row:
    """How one episode ended.

    Attributes:
        schema: version of these fields.
        agent: name of the agent.
        env: id of the environment.
        index: number of the episode.
        seed: seed of scene and agent.
        status: "error" when the episode could not be finished; such rows count in no rate.
        success: ``is_success`` at the end.
        complete: ``complete_rate`` at the end, in [0, 1].
        steps: control steps taken.
        return_: sum of the rewards.
        diverged: the physics blew up.
        message: why the status is "error", else empty.
        seconds: [s] wall time of the whole episode.
        act_seconds: [s] mean wall time of one ``act``.
        privileged: the agent was given the simulator or the expert's solution.
    """

    schema: int = SCHEMA
    agent: str
    env: str
    index: int
    seed: int
    status: Literal["ok", "error"]
    success: bool
    complete: float
    steps: int
    return_: float
    diverged: bool
    message: str
    seconds: float
    act_seconds: float
    privileged: bool

    def __post_init__(self) -> None:
        """Refuse values of a wrong type or range, so that no bad number reaches a table."""
        for name, value in asdict(self).items():
            kind = _KINDS[name]
            fits = type(value) is kind or (kind is float and type(value) is int)
            if not fits or (kind is float and not math.isfinite(value)):
                raise ValueError(f"{name} must be a finite {kind.__name__}, got {value!r}")
        if self.status not in ("ok", "error"):
            raise ValueError(f"status must be 'ok' or 'error', got {self.status!r}")
        if not 0.0 <= self.complete <= 1.0:
            raise ValueError(f"complete must be in [0, 1], got {self.complete!r}")

    @property
    def key(self) -> JobKey:
        """Key of the job this row answers."""
        return (self.agent, self.env, self.index)

    def without_times(self) -> Row:
        """The part that another run of the same episode must reproduce."""
        return replace(self, seconds=0.0, act_seconds=0.0)

    def to_line(self) -> str:
        """One line of JSON, newline included."""
        return json.dumps(asdict(self), allow_nan=False) + "\n"


_KINDS: dict[str, type] = {
    **dict.fromkeys(("agent", "env", "status", "message"), str),
    **dict.fromkeys(("schema", "index", "seed", "steps"), int),
    **dict.fromkeys(("success", "diverged", "privileged"), bool),
    **dict.fromkeys(("complete", "return_", "seconds", "act_seconds"), float),
}


def row_from_record(record: object) -> Row:
    """Check a parsed line and make a row of it.

    Raises:
        ValueError: not a row; the message names the field.
    """
    if not isinstance(record, dict):
        raise ValueError(f"expected a JSON object, got {type(record).__name__}")
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
    privileged: bool = False,
) -> Row:
    """Row of an episode that could not be finished."""
    return Row(
        agent=job.agent,
        env=job.env,
        index=job.index,
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
