"""Triangles in object space."""

import copy
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glimt import linalg
from glimt.errors import GlimtError
from glimt.scene import checks
from glimt.scene.material import Material


@dataclass(eq=False)
class Mesh:
    """Triangles with shared vertices; counter-clockwise is the front, both sides are drawn.

    A corner where normals or texcoords differ is two vertices. Arrays are checked and copied to the types below;
    after that a mesh is not changed (the engine keeps its tree): for moved vertices see `with_positions`.

    Parameters
    ----------
    positions : (n, 3) float32
    triangles : (m, 3) int32
        Vertex indices.
    normals : (n, 3) float32, optional
        Shading normals, any length. None: each triangle is flat.
    texcoords : (n, 2) float32, optional
        (0, 0) is the top-left corner of the texture, as in glTF.
    materials : sequence of Material
        At least one; the default is plain grey.
    material_ids : (m,) int32, optional
        Index into `materials` for each triangle. None: all 0.
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32] | None = None
    texcoords: NDArray[np.float32] | None = None
    materials: list[Material] = field(default_factory=lambda: [Material()])
    material_ids: NDArray[np.int32] | None = None
    name: str = "mesh"
    moved_from: "Mesh | None" = field(default=None, init=False, repr=False)
    """The mesh whose tree fits this one's triangles; forgotten as soon as this one has a tree of its own."""

    def __post_init__(self) -> None:
        owner = f"mesh {self.name!r}"
        self.positions = checks.coordinates(owner, "positions", self.positions, (None, 3))
        count = len(self.positions)
        triangles = checks.array(owner, "triangles", self.triangles, (None, 3), np.int64)
        if triangles.size and not 0 <= triangles.min() <= triangles.max() < count:
            bad = int(np.flatnonzero(((triangles < 0) | (triangles >= count)).any(1))[0])
            raise GlimtError(f"{owner}: triangle {bad} refers to vertices {triangles[bad].tolist()} of {count}")
        self.triangles = triangles.astype(np.int32)
        if self.normals is not None:
            self.normals = checks.coordinates(owner, "normals", self.normals, (count, 3))
        if self.texcoords is not None:
            self.texcoords = checks.coordinates(owner, "texcoords", self.texcoords, (count, 2))
        checks.kind(owner, "materials", self.materials, list, tuple)
        self.materials = list(self.materials)
        for material in self.materials:
            checks.kind(owner, "materials", material, Material)
        if not self.materials:
            raise GlimtError(f"{owner}: no materials; leave the argument out for plain grey")
        self._check_material_ids(owner)

    def _check_material_ids(self, owner: str) -> None:
        if self.material_ids is None:
            self.material_ids = np.zeros(len(self.triangles), np.int32)
        ids = checks.array(owner, "material_ids", self.material_ids, (len(self.triangles),), np.int32)
        if ids.size and not 0 <= ids.min() <= ids.max() < len(self.materials):
            raise GlimtError(f"{owner}: material_ids go from {ids.min()} to {ids.max()}, there are "
                             f"{len(self.materials)} materials")
        self.material_ids = ids

    def bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return (lo, hi) of the vertices that triangles use; (0, 0) for a mesh without triangles."""
        return self._bounds

    @cached_property
    def _bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        if not len(self.triangles):
            return np.zeros(3, np.float32), np.zeros(3, np.float32)
        corners = [self.positions[column] for column in self.triangles.T]
        return np.min([each.min(0) for each in corners], 0), np.max([each.max(0) for each in corners], 0)

    def with_positions(self, positions: ArrayLike, normals: ArrayLike | None = None) -> "Mesh":
        """Return this mesh with its vertices elsewhere, for an animation.

        Give it to the instances in place of this one and call `Renderer.update`: the tree is fitted to the moved
        triangles, which takes a small part of the time of building one. Rays slow down as the mesh loses its first
        shape; a `Mesh` made anew gets a new tree.

        Parameters
        ----------
        positions : (n, 3) float32
        normals : (n, 3) float32, optional
            None: means of the moved triangles' normals, weighted by area; a mesh without normals stays flat.
        """
        owner, count = f"mesh {self.name!r}", len(self.positions)
        moved = copy.copy(self)
        moved.__dict__.pop("_bounds", None)
        moved.materials = list(self.materials)
        moved.positions = checks.coordinates(owner, "positions", positions, (count, 3))
        if normals is not None:
            moved.normals = checks.coordinates(owner, "normals", normals, (count, 3))
        elif self.normals is not None:
            moved.normals = _mean_normals(moved.positions, self.triangles, self.normals)
        moved.moved_from = self.moved_from or self
        return moved


def _mean_normals(positions: NDArray[np.float32], triangles: NDArray[np.int32],
                  otherwise: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return (n, 3) unit normals, means of the triangles around each vertex; `otherwise` where they cancel out."""
    a, b, c = (positions[column].astype(np.float64) for column in triangles.T)
    faces = np.cross(b - a, c - a)
    sums = sum(np.stack([np.bincount(column, faces[:, axis], len(positions)) for axis in range(3)], 1)
               for column in triangles.T)
    unit = linalg.normalize(sums)
    return np.where(unit.any(1, keepdims=True), unit, otherwise).astype(np.float32)
