"""What ``icd-bench export-scene`` does: one scene, at its start, as a file."""

from __future__ import annotations

from pathlib import Path

from benchmarks.console import Values
from benchmarks.contact_env import contact_env
from icd_envs.export import export_glb


def export_scene(env_id: str, out: Path, *, seed: int, split: str) -> Values:
    """Draw a scene and write it.

    Args:
        env_id: which environment, with a task of this package or of your own.
        out: file to write, ends in ``.glb``.
        seed: of the scene.
        split: ``train`` or ``test``.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unknown environment or split, impossible seed or file.
    """
    with contact_env(env_id, (("split", split),)) as env:
        env.reset(seed=seed)
        geoms = export_glb(env, out)
    return {"file": str(out), "geoms": geoms, "kilobytes": out.stat().st_size / 1e3}
