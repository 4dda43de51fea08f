"""Which code, on which machine, with which libraries."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from importlib import metadata
from pathlib import Path
from types import ModuleType

_ROOT = Path(__file__).parents[1]
_PACKAGES = (
    "implicit-contact-diffuser",
    "numpy",
    "mujoco",
    "dm-control",
    "gymnasium",
    "scipy",
    "torch",
    "diffusers",
    "safetensors",
)
# What decides how an episode ends; reports and tables may change without invalidating rows.
_FINGERPRINTED = ("icd_envs", "icd_agent", "baselines")
_OURS = (*_FINGERPRINTED, "benchmarks")
_MISSING = "not installed"
_SUFFIXES = (".py", ".json", ".safetensors", ".xml")
WEIGHT_FILES = ("config.json", "model.safetensors")
"""Of a trained network."""


def cpu_count() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def package_versions(names: Sequence[str] = _PACKAGES) -> dict[str, str]:
    """Installed versions, by default of the packages that decide how an episode ends."""
    return {name: _version(name) for name in names}


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return _MISSING


def code_fingerprint() -> str:
    """Hash of the sources and weights that decide how an episode ends."""
    files = (
        path
        for package in _FINGERPRINTED
        for path in (_ROOT / package).rglob("*")
        if path.suffix in _SUFFIXES
    )
    return _fingerprint(files, _ROOT)


def source_of_file(path: Path) -> str:
    """Name and hash of a file."""
    return f"{path.name} {_fingerprint([path], path.parent)}"


def source_of_folder(folder: Path, names: Sequence[str]) -> str:
    """Name of a folder, and a hash of the files of these names in and below it."""
    files = [path for path in folder.rglob("*") if path.name in names]
    return f"{folder.name} {_fingerprint(files, folder)}"


def source_of_module(module: ModuleType, distribution: str = "") -> str:
    """Distribution, package or file, and a hash of its sources.

    Those of a file are also the modules beside and below it that are imported by now.

    Args:
        module: imported.
        distribution: its name and version; else the installed one of the same name is looked for.
    """
    top = module.__name__.partition(".")[0]
    package = sys.modules[top]
    if hasattr(package, "__path__") and package.__file__:
        root = Path(package.__file__).parent
        source = f"{top} {_fingerprint(root.rglob('*.py'), root)}"
    elif module.__file__:
        source = _source_of_script(Path(module.__file__).resolve())
    else:
        source = module.__name__
    if not distribution and (version := _version(top)) != _MISSING:
        distribution = f"{top} {version}"
    return ", ".join(filter(None, (distribution, source)))


def _source_of_script(path: Path) -> str:
    installed = [Path(sysconfig.get_path(kind)) for kind in ("stdlib", "purelib", "platlib")]
    elsewhere = [folder.resolve() for folder in (*installed, *(_ROOT / name for name in _OURS))]
    named = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    imported = {Path(name).resolve() for name in named if name and os.path.isabs(name)}
    beside = {
        file
        for file in imported
        if file.suffix == ".py" and file.is_file() and file.is_relative_to(path.parent)
        and not any(file.is_relative_to(folder) for folder in elsewhere)
    }  # fmt: skip
    return f"{path.name} {_fingerprint({path, *beside}, path.parent)}"


def _fingerprint(files: Iterable[Path], root: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(files):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(root).as_posix()}:{len(content)}:".encode())
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
    """Commit, and whether our packages were changed, if these sources are a checkout.

    What else lies in the checkout does not matter: the files of an agent have hashes of their own.
    """
    if not (_ROOT / ".git").exists():
        return None, None
    try:
        commit = _git("rev-parse", "HEAD")
        return commit, bool(_git("status", "--porcelain", "--", *_OURS))
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
