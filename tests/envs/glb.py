"""Meshes read back from a GLB, and how large they should be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import trimesh
from mujoco import mjtGeom

from icd_envs.physics.camera import VISIBLE_GROUPS
from icd_envs.physics.gltf import Y_UP

FLAT = 0.025
"""Share of its volume and radius that a round shape loses by its flat faces, at most."""
STRAIGHT = (mjtGeom.mjGEOM_PLANE, mjtGeom.mjGEOM_BOX)


def reloaded(content: bytes | Path) -> dict[str, trimesh.Trimesh]:
    """Meshes of a GLB by node, in world coordinates, z up."""
    source: Any = trimesh.util.wrap_as_stream(content) if isinstance(content, bytes) else content
    scene = trimesh.load_scene(source, file_type="glb")
    found = {}
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        found[node] = scene.geometry[name].copy().apply_transform(np.linalg.inv(Y_UP) @ pose)
    return found


def check_meshes(
    meshes: dict[str, trimesh.Trimesh], model: mujoco.MjModel, data: mujoco.MjData
) -> None:
    """There is a mesh of every visible geom, as large as its definition says, where it is."""
    visible = np.flatnonzero(VISIBLE_GROUPS[model.geom_group])
    names = [model.geom(geom).name or f"geom_{geom}" for geom in visible]
    assert meshes.keys() == set(names)
    for geom, name in zip(visible, names, strict=True):
        kind = mjtGeom(model.geom_type[geom])
        if kind == mjtGeom.mjGEOM_MESH:
            continue
        loss = 0.0 if kind in STRAIGHT else FLAT
        bounds = meshes[name].bounds
        close = 1e-6 + loss * model.geom_size[geom, 0]
        half = half_extents(model, data, geom)
        np.testing.assert_allclose(bounds[1] - bounds[0], 2 * half, atol=close)
        np.testing.assert_allclose(bounds.mean(axis=0), data.geom_xpos[geom], atol=close)
        if kind != mjtGeom.mjGEOM_PLANE:
            share = meshes[name].volume / volume(model, geom)
            assert 1 - loss - 1e-5 <= share <= 1 + 1e-5, name


def half_extents(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> np.ndarray:
    """(3,) of the smallest upright box round a geom, from its definition."""
    a, b, c = model.geom_size[geom]
    rotation = np.abs(data.geom_xmat[geom].reshape(3, 3))
    axis = rotation[:, 2]
    return {
        mjtGeom.mjGEOM_PLANE: rotation @ [a, b, 0.0],
        mjtGeom.mjGEOM_BOX: rotation @ [a, b, c],
        mjtGeom.mjGEOM_SPHERE: np.full(3, a),
        mjtGeom.mjGEOM_CYLINDER: b * axis + a * np.sqrt(np.maximum(0.0, 1 - axis**2)),
        mjtGeom.mjGEOM_CAPSULE: b * axis + a,
    }[mjtGeom(model.geom_type[geom])]


def volume(model: mujoco.MjModel, geom: int) -> float:
    """[m^3] from its definition."""
    a, b, c = model.geom_size[geom]
    return {
        mjtGeom.mjGEOM_BOX: 8 * a * b * c,
        mjtGeom.mjGEOM_SPHERE: 4 / 3 * np.pi * a**3,
        mjtGeom.mjGEOM_CYLINDER: 2 * np.pi * a**2 * b,
        mjtGeom.mjGEOM_CAPSULE: 2 * np.pi * a**2 * b + 4 / 3 * np.pi * a**3,
    }[mjtGeom(model.geom_type[geom])]
