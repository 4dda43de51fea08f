from __future__ import annotations

import json
from pathlib import Path

import pytest

from icd_envs.demonstrations.header import FILE_NAME, read_header
from icd_envs.errors import DemonstrationsError
from tests.demonstrations.making import make_header


def test_header_survives_the_file(tmp_path: Path) -> None:
    header = make_header(split="test", noisy=False)
    (tmp_path / FILE_NAME).write_bytes(header.to_json())
    assert read_header(tmp_path) == header


@pytest.mark.parametrize(("episodes", "sizes"), [(1, [1]), (4, [2, 2]), (5, [2, 2, 1])])
def test_shards_hold_every_episode_once(episodes: int, sizes: list[int]) -> None:
    header = make_header(episodes=episodes)
    shards = [header.indices(number) for number in range(header.shards)]
    assert [len(shard) for shard in shards] == sizes
    assert [index for shard in shards for index in shard] == list(range(episodes))


@pytest.mark.parametrize(
    "wrong",
    [
        {"episodes": 0},
        {"steps": True},
        {"seed": -1},
        {"split": "all"},
        {"noisy": 1},
        {"env_id": 3},
        {"options": {"goals": 1.5}},
    ],
)
def test_impossible_values_are_refused_by_name(wrong: dict[str, object]) -> None:
    with pytest.raises(DemonstrationsError, match=next(iter(wrong))):
        make_header(**wrong)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "cannot read"),
        ("[]", "is not a header"),
        ('{"format": 1}', "is not a header"),
        (None, "make some with icd-bench collect"),
    ],
)
def test_anything_else_is_an_error_naming_the_file(
    tmp_path: Path, text: str | None, reason: str
) -> None:
    if text is not None:
        (tmp_path / FILE_NAME).write_text(text)
    with pytest.raises(DemonstrationsError, match=f"{FILE_NAME}.*{reason}|{reason}.*{FILE_NAME}"):
        read_header(tmp_path)


@pytest.mark.parametrize(("field", "value"), [("format", 2), ("episodes", "many")])
def test_other_format_or_bad_value_is_an_error(tmp_path: Path, field: str, value: object) -> None:
    record = {**json.loads(make_header().to_json()), field: value}
    (tmp_path / FILE_NAME).write_text(json.dumps(record))
    with pytest.raises(DemonstrationsError, match=rf"{FILE_NAME}: {field} must be"):
        read_header(tmp_path)
