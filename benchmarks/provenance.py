"""Which code, on which machine, with which libraries."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path

_ROOT = Path(__file__).parents[1]
_PACKAGES = (
    "implicit-contact-diffuser",
    "numpy",
    "mujoco",
    "dm-control",
    "gymnasium",
    "scipy",
)
# What decides how an episode ends; reports and tables may change without invalidating rows.
_FINGERPRINTED = ("icd_envs", "icd_agent", "baselines")
_SUFFIXES = (".py", ".json", ".safetensors", ".xml")


def cpu_count() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def python_version() -> str:
    """Version of the interpreter."""
    return platform.python_version()


def platform_name() -> str:
    """Operating system and architecture."""
    return platform.platform()


def package_versions() -> dict[str, str]:
    """Installed versions of the packages that decide how an episode ends."""
    return {name: _version(name) for name in _PACKAGES}


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def code_fingerprint() -> str:
    """Hash of the sources and weights that decide how an episode ends."""
    digest = hashlib.sha256()
    files = (
        path
        for package in _FINGERPRINTED
        for path in (_ROOT / package).rglob("*")
        if path.suffix in _SUFFIXES
    )
    for path in sorted(files):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(_ROOT).as_posix()}:{len(content)}:".encode())
        digest.update(content)
    return f"sha256:{digest.hexdigest()}"


def weight_hashes() -> dict[str, str]:
    """Hashes of the shipped weight files, by path."""
    files = sorted(
        path for name in _FINGERPRINTED for path in (_ROOT / name).rglob("*.safetensors")
    )
    return {
        path.relative_to(
            _ROOT
        ).as_posix(): f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}"
        for path in files
    }


def git_state() -> tuple[str | None, bool | None]:
    """Commit and dirty flag, if these sources are a checkout and not merely installed in one."""
    if not (_ROOT / ".git").exists():
        return None, None
    try:
        commit = _git("rev-parse", "HEAD")
        return commit, bool(_git("status", "--porcelain"))
    except (OSError, subprocess.SubprocessError):
        return None, None


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(_ROOT), *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, check=True, timeout=10
    ).stdout.strip()


def cpu_model() -> str:
    """What the operating system calls the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or "unknown")
