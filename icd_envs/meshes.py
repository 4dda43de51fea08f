"""The solid parts of a scene as triangle meshes, for viewers other than MuJoCo's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from icd_envs.api import Float64Array, FloatArray

if TYPE_CHECKING:
    import mujoco


@dataclass(frozen=True)
class Mesh:
    """One rigid part.

    Attributes:
        name: of the geom.
        vertices: (V, 3) [m] in its own frame.
        faces: (F, 3) indices of vertices.
        position: (3,) [m] of that frame in the world.
        rotation: (3, 3) columns are its axes in the world.
        rgba: colour, 0 to 1.
    """

    name: str
    vertices: Float64Array
    faces: NDArray[np.int64]
    position: Float64Array
    rotation: Float64Array
    rgba: FloatArray


def group_meshes(model: mujoco.MjModel, data: mujoco.MjData, group: int) -> list[Mesh]:
    """Every part of one group of geoms.

    Args:
        model: the scene.
        data: its state; positions must be up to date.
        group: as in ``icd_envs.scenes.layers``.

    Raises:
        SceneExportError: on a geom without a mesh.
    """
    from icd_envs.physics.gltf import colour_of, shape_of

    found = []
    for index in np.flatnonzero(model.geom_group == group):
        mesh = shape_of(model, int(index))
        found.append(
            Mesh(
                name=model.geom(index).name,
                vertices=np.asarray(mesh.vertices),
                faces=np.asarray(mesh.faces),
                position=data.geom_xpos[index].copy(),
                rotation=data.geom_xmat[index].reshape(3, 3).copy(),
                rgba=colour_of(model, int(index)),
            )
        )
    return found
