"""Fingerprints and git state, in a checkout made by hand."""

from __future__ import annotations

import hashlib
import subprocess
from pathlib import Path

import pytest

from benchmarks import provenance
from benchmarks.provenance import code_fingerprint, git_state, weight_hashes

WEIGHTS = "icd_agent/shipped/toy/model.safetensors"
FILES = {
    "icd_envs/task.py": "a",
    "icd_envs/scene.xml": "b",
    "icd_envs/__init__.py": "",
    "icd_agent/shipped/toy/config.json": "c",
    WEIGHTS: "d",
    "baselines/agent.py": "e",
    "benchmarks/cli.py": "f",
    "icd_agent/notes.md": "g",
    "docs/page.md": "h",
    "my_agent.py": "i",
}
DECIDING = ["icd_envs/task.py", "icd_envs/scene.xml", "baselines/agent.py", WEIGHTS,
            "icd_agent/shipped/toy/config.json"]  # fmt: skip


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with these files, committed."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(provenance, "_ROOT", tmp_path)
    git(tmp_path, "init", "--quiet")
    commit(tmp_path)
    return tmp_path


def git(root: Path, *arguments: str) -> str:
    who = ["-c", "user.name=nobody", "-c", "user.email=nobody@nowhere", "-c", "commit.gpgsign=no"]
    done = subprocess.run(
        ["git", "-C", root, *who, *arguments], capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def commit(root: Path) -> str:
    git(root, "add", "--all")
    git(root, "commit", "--quiet", "--message", "what is there")
    return git(root, "rev-parse", "HEAD")


@pytest.mark.parametrize("name", DECIDING)
def test_fingerprint_follows_content_name_and_presence(root: Path, name: str) -> None:
    before, path = code_fingerprint(), root / name
    seen = [before]
    path.write_text(FILES[name].upper())
    seen.append(code_fingerprint())
    path.write_text(FILES[name])
    assert code_fingerprint() == before
    renamed = path.rename(path.with_name(f"other{path.suffix}"))
    seen.append(code_fingerprint())
    renamed.unlink()
    seen.append(code_fingerprint())
    assert len(set(seen)) == 4


def test_fingerprint_tells_which_file_says_what(root: Path) -> None:
    before = code_fingerprint()
    first, second = root / "icd_envs" / "task.py", root / "icd_envs" / "scene.xml"
    first.write_text(FILES["icd_envs/scene.xml"])
    second.write_text(FILES["icd_envs/task.py"])
    assert code_fingerprint() != before


@pytest.mark.parametrize(
    "name", ["icd_agent/notes.md", "docs/page.md", "benchmarks/cli.py", "my_agent.py", "new.json"]
)
def test_fingerprint_does_not_follow_what_decides_no_episode(root: Path, name: str) -> None:
    before = code_fingerprint()
    (root / name).write_text("something else")
    assert code_fingerprint() == before


def test_weights_are_named_with_the_hash_of_their_bytes(root: Path) -> None:
    (root / "benchmarks" / "other.safetensors").write_text("d")
    for content in (b"d", b"dd"):
        (root / WEIGHTS).write_bytes(content)
        assert weight_hashes() == {WEIGHTS: f"sha256:{hashlib.sha256(content).hexdigest()}"}


@pytest.mark.parametrize("name", [*DECIDING, "icd_agent/notes.md", "benchmarks/cli.py"])
def test_a_checkout_is_dirty_while_our_packages_are_not_as_committed(root: Path, name: str) -> None:
    head = git(root, "rev-parse", "HEAD")
    assert git_state() == (head, False)
    (root / name).write_text("something else")
    assert git_state() == (head, True)
    (root / name).write_text(FILES[name])
    assert git_state() == (head, False)
    (root / name).unlink()
    assert git_state() == (head, True)
    after = commit(root)
    assert after != head
    assert git_state() == (after, False)


def test_a_new_file_makes_our_packages_dirty(root: Path) -> None:
    (root / "icd_envs" / "new.py").write_text("")
    assert git_state()[1] is True


def test_what_else_lies_in_a_checkout_does_not_make_it_dirty(root: Path) -> None:
    for name in ("docs/page.md", "my_agent.py", "new.py"):
        (root / name).write_text("something else")
    assert git_state() == (git(root, "rev-parse", "HEAD"), False)


def test_sources_that_are_no_checkout_have_no_state(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(provenance, "_ROOT", root / "icd_envs")
    assert git_state() == (None, None)
    monkeypatch.setattr(provenance, "_ROOT", root)
    monkeypatch.setenv("PATH", str(root))  # without git
    assert git_state() == (None, None)
