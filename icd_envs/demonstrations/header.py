"""What a folder of demonstrations says about all of its episodes: ``demonstrations.json``."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Final

from icd_envs.errors import DemonstrationsError
from icd_envs.tasks.problem import SPLITS, Split

FILE_NAME: Final = "demonstrations.json"
FORMAT: Final = 1
"""Rises with every change of header or shards that an older reader would misread."""
SHARD_EPISODES: Final = 20
"""Episodes in one file: about 1.3 MB, and what a kill can lose per worker."""


@dataclass(frozen=True, kw_only=True)
class Header:
    """The same for every episode of a folder.

    Attributes:
        format: version of header and shards.
        env_id: whose expert acted.
        options: arguments of ``gymnasium.make`` that the task was given, by name.
        split: which scenes.
        noisy: with action noise, varying speed and deliberate faults.
        seed: base seed; every episode has a seed of its own, kept in its shard.
        steps: control steps after which an episode was ended.
        episodes: in all shards together.
        shard_episodes: in every shard but perhaps the last.
    """

    format: int = FORMAT
    env_id: str
    options: dict[str, int | str] = field(default_factory=dict)
    split: Split = "train"
    noisy: bool = True
    seed: int
    steps: int
    episodes: int
    shard_episodes: int = SHARD_EPISODES

    def __post_init__(self) -> None:
        """Refuse values that no folder can have."""
        for name in ("env_id", "split"):
            if type(getattr(self, name)) is not str:
                raise DemonstrationsError(f"{name} must be text, got {getattr(self, name)!r}")
        if type(self.options) is not dict or not all(
            type(name) is str and type(value) in (int, str) for name, value in self.options.items()
        ):
            raise DemonstrationsError(
                f"options must be integers or texts by name, got {self.options!r}"
            )
        if self.split not in SPLITS or type(self.noisy) is not bool:
            raise DemonstrationsError(
                f"split must be one of {SPLITS} and noisy a bool, got {self.split!r}, "
                f"{self.noisy!r}"
            )
        for name, least in (("seed", 0), ("steps", 1), ("episodes", 1), ("shard_episodes", 1)):
            value = getattr(self, name)
            if type(value) is not int or value < least:
                raise DemonstrationsError(f"{name} must be an integer >= {least}, got {value!r}")

    @property
    def shards(self) -> int:
        """Number of shards."""
        return -(-self.episodes // self.shard_episodes)

    def indices(self, shard: int) -> range:
        """Numbers of the episodes in one shard."""
        first = shard * self.shard_episodes
        return range(first, min(first + self.shard_episodes, self.episodes))

    def to_json(self) -> bytes:
        """The file's content."""
        return (json.dumps(asdict(self), indent=2) + "\n").encode()


def shard_path(folder: Path, shard: int) -> Path:
    """File of one shard."""
    return folder / f"shard-{shard:05d}.npz"


def read_header(folder: Path) -> Header:
    """Read the header of a folder.

    Raises:
        DemonstrationsError: missing, not a header, or of another format.
    """
    path = folder / FILE_NAME
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise DemonstrationsError(
            f"no demonstrations in {folder}: {FILE_NAME} is missing there; make some with "
            "icd-bench collect"
        ) from error
    except (OSError, ValueError) as error:
        raise DemonstrationsError(f"cannot read {path}: {error}") from error
    names = {known.name for known in fields(Header)}
    if not isinstance(record, dict) or set(record) != names:
        raise DemonstrationsError(f"{path} is not a header: it must have the keys {sorted(names)}")
    if record["format"] != FORMAT:
        raise DemonstrationsError(
            f"{path}: format must be {FORMAT}, got {record['format']!r}: read it with the version "
            "of this project that wrote it"
        )
    try:
        return Header(**record)
    except DemonstrationsError as error:
        raise DemonstrationsError(f"{path}: {error}") from error
