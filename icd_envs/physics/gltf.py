"""A compiled scene as glTF has it: what pictures show, without the goal.

Made from the model's geoms alone, so that it fits every task.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import mujoco
import numpy as np
import trimesh
from trimesh.visual.color import srgb_to_linear

from icd_envs.api import Float64Array
from icd_envs.errors import SceneExportError
from icd_envs.scenes.layers import VISIBLE_GROUPS

Y_UP: Final = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
"""World coordinates, z up, to those of glTF, y up."""
SECTIONS: Final = 24
"""Flat faces round a cylinder."""
ROUGHNESS: Final = 0.9
DEFAULT_RGBA: Final = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's: a geom of this colour has its material's."""

Maker = Callable[[Float64Array], trimesh.Trimesh]


def as_trimesh(model: mujoco.MjModel, data: mujoco.MjData) -> trimesh.Scene:
    """The visible geoms in their colours, y up; node ``z_up`` has world coordinates below it.

    Args:
        model: the scene.
        data: state; its positions must be up to date.

    Raises:
        SceneExportError: on a geom of an unknown shape, or without an end.
    """
    scene = trimesh.Scene()
    scene.graph.update(frame_from=scene.graph.base_frame, frame_to="z_up", matrix=Y_UP)
    for geom in np.flatnonzero(VISIBLE_GROUPS[model.geom_group]):
        pose = np.eye(4)
        pose[:3, :3] = data.geom_xmat[geom].reshape(3, 3)
        pose[:3, 3] = data.geom_xpos[geom]
        name = model.geom(geom).name or f"geom_{geom}"
        scene.add_geometry(
            _coloured(model, int(geom)), node_name=name, geom_name=name,
            parent_node_name="z_up", transform=pose,
        )  # fmt: skip
    return scene


def shape_of(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh:
    """One geom in its own frame, without colour.

    Raises:
        SceneExportError: it is of an unknown shape, or without an end.
    """
    kind = mujoco.mjtGeom(model.geom_type[geom])
    size = model.geom_size[geom]
    endless = kind == mujoco.mjtGeom.mjGEOM_PLANE and not size[:2].all()
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return _own_mesh(model, int(model.geom_dataid[geom]))
    if kind not in MAKERS or endless:
        raise SceneExportError(
            f"geom {model.geom(geom).name!r} is of type {kind.name} and size {size.tolist()}, "
            f"which has no mesh: known are {', '.join(known.name for known in MAKERS)}, mjGEOM_MESH"
        )
    return MAKERS[kind](size)


def colour_of(model: mujoco.MjModel, geom: int) -> Float64Array:
    """(4,) colour of a geom in pictures before light falls on it; a texture counts as its mean."""
    rgba: Float64Array = model.geom_rgba[geom].astype(np.float64)
    material = int(model.geom_matid[geom])
    if material < 0:
        return rgba
    if np.array_equal(rgba, DEFAULT_RGBA):
        rgba = model.mat_rgba[material].astype(np.float64)
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture >= 0:
        channels = int(model.tex_nchannel[texture])
        count = int(model.tex_height[texture] * model.tex_width[texture]) * channels
        first = int(model.tex_adr[texture])
        pixels = model.tex_data[first : first + count].reshape(-1, channels)
        rgba[:3] *= pixels[:, :3].mean(axis=0) / 255
    return rgba


def _coloured(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh:
    mesh, rgba = shape_of(model, geom), colour_of(model, geom)
    mesh.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(
            # glTF's factors are linear, MuJoCo's colours are those of the screen.
            baseColorFactor=[*srgb_to_linear(rgba[:3]), rgba[3]],
            metallicFactor=0.0,
            roughnessFactor=ROUGHNESS,
            alphaMode="OPAQUE" if rgba[3] == 1.0 else "BLEND",
        )
    )
    return mesh


def _plane(size: Float64Array) -> trimesh.Trimesh:
    x, y = size[:2]
    corners = [[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]])


MAKERS: Final[dict[mujoco.mjtGeom, Maker]] = {
    mujoco.mjtGeom.mjGEOM_PLANE: _plane,
    mujoco.mjtGeom.mjGEOM_BOX: lambda size: trimesh.creation.box(extents=2 * size),
    mujoco.mjtGeom.mjGEOM_SPHERE: lambda size: trimesh.creation.icosphere(radius=size[0]),
    mujoco.mjtGeom.mjGEOM_CYLINDER: lambda size: trimesh.creation.cylinder(
        radius=size[0], height=2 * size[1], sections=SECTIONS
    ),
    mujoco.mjtGeom.mjGEOM_CAPSULE: lambda size: trimesh.creation.capsule(
        radius=size[0], height=2 * size[1], count=(SECTIONS // 2, SECTIONS)
    ),
}


def _own_mesh(model: mujoco.MjModel, mesh: int) -> trimesh.Trimesh:
    first_vertex, first_face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
    vertices = model.mesh_vert[first_vertex : first_vertex + model.mesh_vertnum[mesh]]
    faces = model.mesh_face[first_face : first_face + model.mesh_facenum[mesh]]
    return trimesh.Trimesh(vertices, faces)
