"""Installed packages with plug-ins, made by hand."""

from __future__ import annotations

from pathlib import Path


def install(folder: Path, package: str, code: str, **entry_points: str) -> None:
    """What pip leaves behind of a package of one module.

    Args:
        folder: where packages are.
        package: name of the package and its module.
        code: of the module.
        entry_points: names of agents, and what they point to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{package}.py").write_text(code)
    info = folder / f"{package}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    lines = [f"{name} = {target}" for name, target in entry_points.items()]
    (info / "entry_points.txt").write_text("\n".join(["[icd.agents]", *lines, ""]))
