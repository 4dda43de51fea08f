"""A scene as a GLB file, for papers, slides and web pages."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import gymnasium as gym

from icd_envs.errors import InvalidOptionError, SceneExportError
from icd_envs.physics.gltf import as_trimesh
from icd_envs.tasks.env import ContactEnv


def export_glb(env: gym.Env[Any, Any], path: str | PathLike[str]) -> int:
    """Write the scene as it is now: metres, one named node per geom, y up as glTF has it.

    Args:
        env: an environment of this project, wrapped or not.
        path: ends in ``.glb``; a file that is there is replaced.

    Returns:
        how many geoms were written.

    Raises:
        InvalidOptionError: if the environment is another, or the path ends otherwise.
        SceneExportError: if there is a geom of an unknown shape, or the file cannot be written.
        EpisodeStateError: before ``reset`` or after ``close``.
    """
    bare = env.unwrapped
    if not isinstance(bare, ContactEnv):
        raise InvalidOptionError(
            f"env must be an environment of this project, got {bare}: gymnasium.make('ICD...')"
        )
    target = Path(path)
    if target.suffix != ".glb":
        raise InvalidOptionError(f"path must end in .glb, got {str(target)!r}")
    scene = as_trimesh(bare.model, bare.data)
    content = scene.export(file_type="glb")
    try:
        target.write_bytes(content)
    except OSError as error:
        raise SceneExportError(
            f"cannot write {target}: {error}: name a file in a folder that exists"
        ) from error
    return len(scene.geometry)
