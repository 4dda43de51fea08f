from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from icd_envs.demonstrations.shard import FIELDS, encode, read_shard
from icd_envs.errors import DemonstrationsError
from tests.demonstrations.making import make_recording

RECORDINGS = [make_recording(2, 0), make_recording(0, 1), make_recording(3, 2, success=True)]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A sound shard."""
    path = tmp_path / "shard-00000.npz"
    path.write_bytes(encode(RECORDINGS))
    return path


def test_arrays_survive_the_file(path: Path) -> None:
    arrays = read_shard(path)
    assert arrays["lengths"].tolist() == [2, 0, 3]
    assert arrays["success"].tolist() == [False, False, True]
    assert arrays["scene_ids"].tolist() == [b"0123456789abcdef"] * 3
    for name in ("nodes", "gripper", "solved", "actions"):
        np.testing.assert_array_equal(
            arrays[name], np.concatenate([getattr(r, name) for r in RECORDINGS])
        )
    clips = np.stack([r.parameters["clips"] for r in RECORDINGS])
    np.testing.assert_array_equal(arrays["parameter_clips"], clips)


def test_equal_episodes_give_equal_bytes() -> None:
    assert encode(RECORDINGS) == encode([make_recording(2, 0), *RECORDINGS[1:]])
    assert encode(RECORDINGS) != encode([make_recording(2, 7), *RECORDINGS[1:]])


def test_missing_shard_is_named(tmp_path: Path) -> None:
    with pytest.raises(DemonstrationsError, match=r"shard-00003\.npz is missing"):
        read_shard(tmp_path / "shard-00003.npz")


@settings(max_examples=60, deadline=None)
@given(cut=st.floats(0.0, 1.0, exclude_max=True))
def test_truncated_shard_is_an_error_naming_the_file(
    tmp_path_factory: pytest.TempPathFactory, cut: float
) -> None:
    content = encode(RECORDINGS)
    path = tmp_path_factory.mktemp("cut") / "shard-00000.npz"
    path.write_bytes(content[: int(cut * len(content))])
    with pytest.raises(DemonstrationsError, match=r"shard-00000\.npz is damaged.*delete it"):
        read_shard(path)


@settings(max_examples=150, deadline=None)
@given(place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_flipped_bit_never_changes_a_value_silently(
    tmp_path_factory: pytest.TempPathFactory, place: float, bit: int
) -> None:
    content = bytearray(encode(RECORDINGS))
    path = tmp_path_factory.mktemp("flip") / "shard-00000.npz"
    path.write_bytes(content)
    sound = read_shard(path)
    content[int(place * len(content))] ^= 1 << bit
    path.write_bytes(content)
    try:
        arrays = read_shard(path)
    except DemonstrationsError as error:
        message, arrays = str(error), sound
    else:  # a bit that no reader looks at, such as a date
        message = path.name
    assert path.name in message
    assert set(arrays) == set(sound)
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, sound[name])


def test_pickled_arrays_are_never_loaded(tmp_path: Path) -> None:
    path = tmp_path / "shard-00000.npz"
    np.savez(path, lengths=np.array([{}], dtype=object))
    with pytest.raises(DemonstrationsError, match=r"damaged.*allow_pickle=False"):
        read_shard(path)


@pytest.mark.parametrize("name", FIELDS)
def test_missing_or_misshapen_array_is_named(path: Path, name: str) -> None:
    arrays = read_shard(path)
    np.savez(path, **{key: value for key, value in arrays.items() if key != name})
    with pytest.raises(DemonstrationsError, match=f"not a shard.*{name}"):
        read_shard(path)
    np.savez(path, **{**arrays, name: arrays[name].astype(np.complex128)
                      if arrays[name].dtype.kind != "S" else arrays[name][:-1]})  # fmt: skip
    with pytest.raises(DemonstrationsError, match=f"not a shard.*{name}"):
        read_shard(path)


def test_other_files_are_refused(tmp_path: Path) -> None:
    for number, content in enumerate([b"", b"hello", np.arange(3).tobytes()]):
        path = tmp_path / f"shard-{number:05d}.npz"
        path.write_bytes(content)
        with pytest.raises(DemonstrationsError, match=path.name):
            read_shard(path)
    np.save(tmp_path / "array.npy", np.arange(3))
    with pytest.raises(DemonstrationsError, match=r"array\.npy"):
        read_shard(tmp_path / "array.npy")


def test_flipped_bit_in_the_zips_directory_never_loses_an_array(tmp_path: Path) -> None:
    sound, path = encode(RECORDINGS), tmp_path / "shard-00000.npz"
    path.write_bytes(sound)
    names, refused = set(read_shard(path)), 0
    for place in range(len(sound) - 22, len(sound)):  # the record of where the directory ends
        for bit in range(8):
            content = bytearray(sound)
            content[place] ^= 1 << bit
            path.write_bytes(content)
            try:
                assert set(read_shard(path)) == names
            except DemonstrationsError:
                refused += 1
    assert refused > 20
