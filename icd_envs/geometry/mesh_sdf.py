"""Signed distance to any closed mesh, for scenes that are not made of boxes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from icd_envs.api import Float64Array, FloatArray
from icd_envs.errors import InvalidOptionError

if TYPE_CHECKING:
    import trimesh

ON_SURFACE = 1e-9
"""[m] points closer than this have the direction of the face's normal."""


class MeshSolid:
    """Signed distance to a closed mesh, through trimesh; slower than ``BoxUnion``.

    Needs the extra ``[meshes]``.
    """

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        """Build the search tree.

        Args:
            mesh: closed, in the world frame [m].

        Raises:
            InvalidOptionError: the mesh has holes, so that it has no inside, or rtree is missing.
        """
        from trimesh.proximity import ProximityQuery

        if not mesh.is_watertight:
            raise InvalidOptionError("mesh is not closed, so it has no inside: fill its holes")
        try:
            import rtree  # noqa: F401  trimesh would fail at the first query
        except ImportError as error:
            raise InvalidOptionError(
                "meshes need rtree: pip install 'implicit-contact-diffuser[meshes]'"
            ) from error
        self._mesh = mesh
        self._query = ProximityQuery(mesh)

    def __call__(self, points: FloatArray) -> Float64Array:
        """Signed distance (M,) [m] of points (M, 3) [m], negative inside."""
        return -np.asarray(self._query.signed_distance(points), np.float64)

    def gradient(self, points: FloatArray) -> Float64Array:
        """Direction in which the signed distance grows, (M, 3) unit vectors, of points (M, 3)."""
        closest, distance, triangle = self._query.on_surface(points)
        outward = np.sign(self(points))[:, None] * (points - closest)
        on_surface = distance < ON_SURFACE
        outward[on_surface] = self._mesh.face_normals[triangle[on_surface]]
        return np.asarray(outward / np.linalg.norm(outward, axis=1, keepdims=True), np.float64)
