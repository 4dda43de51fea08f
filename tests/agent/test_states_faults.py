"""Kept features when something goes wrong: never zeros, never half of them, never a traceback."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from icd_agent import states as module
from icd_agent.chain import Features
from icd_agent.kept import KINDS, PROGRESS
from icd_agent.locking import alone
from icd_agent.scene_tokens import SceneTokens
from icd_agent.states import States, describe_states
from icd_envs.api import Float32Array
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError
from tests.agent.test_states import EPISODES, Describe, KilledError, compute
from tests.demonstrations.making import make_folder


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory: pytest.TempPathFactory) -> Demonstrations:
    return Demonstrations(make_folder(tmp_path_factory.mktemp("data"), episodes=EPISODES))


@pytest.fixture(scope="module")
def whole(demonstrations: Demonstrations, tmp_path_factory: pytest.TempPathFactory) -> States:
    return compute(demonstrations, tmp_path_factory.mktemp("whole"), Describe())


def same(one: States, other: States) -> None:
    for name, array in one._asdict().items():
        for ours, theirs in zip(_parts(array), _parts(getattr(other, name)), strict=True):
            np.testing.assert_array_equal(ours, theirs)


def _parts(value: object) -> tuple[object, ...]:
    return tuple(value) if isinstance(value, SceneTokens) else (value,)


def full(*arguments: object) -> None:
    raise OSError(28, "No space left on device")


def test_a_second_call_is_refused_while_the_first_fills_the_folder(
    demonstrations: Demonstrations, whole: States, tmp_path: Path
) -> None:
    class Interrupted(Describe):
        def __call__(self, scene: Float32Array) -> tuple[Features, SceneTokens]:
            with pytest.raises(DemonstrationsError, match=r"in use by another .* or copy the dem"):
                compute(demonstrations, tmp_path, Describe())
            return super().__call__(scene)

    same(compute(demonstrations, tmp_path, Interrupted()), whole)


def test_what_is_complete_is_read_without_a_lock_or_the_right_to_write(
    demonstrations: Demonstrations, whole: States, tmp_path: Path
) -> None:
    compute(demonstrations, tmp_path, Describe())
    with alone(tmp_path):
        same(compute(demonstrations, tmp_path, Describe(0)), whole)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-4])


def shorter(path: Path) -> None:
    np.save(path, np.load(path)[:, :-1])


def _write(text: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(text)


DAMAGE: dict[str, tuple[str, Callable[[Path], object]]] = {
    "empty record": (PROGRESS, _write("")),
    "a list": (PROGRESS, _write("[]")),
    "no JSON": (PROGRESS, _write('{"done": 1')),
    "done is missing": (PROGRESS, _write("{}")),
    "cut off": ("features.npy", cut),
    "removed": ("clouds.npy", Path.unlink),
    "empty": ("places.npy", _write("")),
    "another shape": ("features.npy", shorter),
    "no array": ("scene.npy", _write("PK nonsense")),
}


@pytest.mark.parametrize("kind", DAMAGE)
@pytest.mark.parametrize("complete", [True, False])
def test_damage_is_named_with_what_to_delete(
    demonstrations: Demonstrations,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    kind: str,
    complete: bool,
) -> None:
    monkeypatch.setattr(module, "SAVE_EVERY", 1)
    if complete:
        compute(demonstrations, tmp_path, Describe())
    else:
        with pytest.raises(KilledError):
            compute(demonstrations, tmp_path, Describe(1))
    name, damage = DAMAGE[kind]
    damage(tmp_path / name)
    with pytest.raises(DemonstrationsError, match=rf"{name} is missing or damaged.* delete "):
        compute(demonstrations, tmp_path, Describe())


@pytest.mark.parametrize("done", [EPISODES + 1, -1, "1", 1.0, None])
def test_a_record_of_more_than_there_is_was_damaged(
    demonstrations: Demonstrations, tmp_path: Path, done: object
) -> None:
    compute(demonstrations, tmp_path, Describe())
    record = json.loads((tmp_path / PROGRESS).read_text())
    (tmp_path / PROGRESS).write_text(json.dumps({**record, "done": done}))
    with pytest.raises(DemonstrationsError, match="damaged: done="):
        compute(demonstrations, tmp_path, Describe())


def test_a_disk_without_room_is_noticed_before_anything_is_computed(
    demonstrations: Demonstrations,
    whole: States,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(os, "posix_fallocate", full, raising=False)
        with pytest.raises(DemonstrationsError, match=r"needs 0\.\d+ GB: cannot write .*No space"):
            compute(demonstrations, tmp_path, Describe(1))
    assert not list(tmp_path.glob("*.npy"))
    same(compute(demonstrations, tmp_path, Describe()), whole)


def test_arrays_have_their_space_on_the_disk_from_the_beginning(
    demonstrations: Demonstrations, tmp_path: Path
) -> None:
    if not hasattr(os, "posix_fallocate"):
        pytest.skip("files have holes here")
    with pytest.raises(KilledError):
        compute(demonstrations, tmp_path, Describe(1))
    for name in KINDS:
        there = (tmp_path / f"{name}.npy").stat()
        assert there.st_blocks * 512 >= there.st_size


def test_a_disk_that_is_full_at_a_save_keeps_the_last_one(
    demonstrations: Demonstrations,
    whole: States,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "SAVE_EVERY", 1)
    with pytest.raises(KilledError):
        compute(demonstrations, tmp_path, Describe(1))
    before = (tmp_path / PROGRESS).read_bytes()
    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(DemonstrationsError, match=r"cannot write .*free some space"):
            compute(demonstrations, tmp_path, Describe())
    assert (tmp_path / PROGRESS).read_bytes() == before
    assert not list(tmp_path.glob("*.new"))
    same(compute(demonstrations, tmp_path, Describe(EPISODES - 1)), whole)


def test_a_folder_that_cannot_be_made_is_an_error_of_one_line(
    demonstrations: Demonstrations, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DemonstrationsError, match=r"cannot write .*copy the demonstrations"):
        compute(demonstrations, tmp_path / "file" / "kept", Describe())


def test_states_of_a_diverged_episode_are_left_out(
    demonstrations: Demonstrations, whole: States, tmp_path: Path
) -> None:
    second = copy.copy(demonstrations)
    second.diverged = np.arange(EPISODES) == 1
    left = compute(second, tmp_path, Describe())
    kept = whole.episode != 1
    np.testing.assert_array_equal(left.features, whole.features[kept])
    np.testing.assert_array_equal(left.step, whole.step[kept])
    np.testing.assert_array_equal(left.episode, whole.episode[kept] // 2)
    np.testing.assert_array_equal(left.tokens.places, whole.tokens.places[::2])
    np.testing.assert_array_equal(left.success, whole.success[::2])
    assert left.first[-1] == len(left.step)


def test_nothing_but_diverged_episodes_is_refused(
    demonstrations: Demonstrations, tmp_path: Path
) -> None:
    none = copy.copy(demonstrations)
    none.diverged = np.ones(EPISODES, bool)
    with pytest.raises(DemonstrationsError, match="diverged in all of the first 2 episodes"):
        describe_states(none, Describe(), tmp_path, space="toy", episodes=2)
