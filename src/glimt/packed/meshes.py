"""One mesh as arrays: its tree, its triangles in leaf blocks, and what shading needs."""

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from glimt import bvh
from glimt.layout import LEAF_SIZE, TANGENT, TRIANGLE_BLOCK, VERTEX
from glimt.scene.mesh import Mesh
from glimt.scene.tangents import tangent_space

_BOX_PAD = np.float32(2.0**-21)
"""As a share of a triangle's largest coordinate: eight times what float32 rounds off."""


class PackedMesh(NamedTuple):
    """Arrays of one mesh; indices are local to it.

    tree : WideTree
    blocks : (b, TRIANGLE_BLOCK.words) float32
    vertices : (n, VERTEX.words) float32
    tangents : (n, TANGENT.words) float32, or (0, ...) for a mesh that needs none
    triangles : (m, 3) int32
    """

    tree: bvh.WideTree
    blocks: NDArray[np.float32]
    vertices: NDArray[np.float32]
    tangents: NDArray[np.float32]
    triangles: NDArray[np.int32]


_PACKED: "WeakKeyDictionary[Mesh, dict[bool, PackedMesh]]" = WeakKeyDictionary()


def pack_mesh(mesh: Mesh, with_tangents: bool, threads: int) -> PackedMesh:
    """Return the arrays of a mesh, kept as long as the mesh lives."""
    known = _PACKED.setdefault(mesh, {})
    if with_tangents not in known:
        tree, blocks = next(((p.tree, p.blocks) for p in known.values()), (None, None))
        if tree is None or blocks is None:
            corners = mesh.positions[mesh.triangles]
            tree = bvh.build(*_boxes(corners), threads)
            blocks = _leaf_blocks(corners, tree.leaf_prims)
        known[with_tangents] = PackedMesh(tree, blocks, *_shading_arrays(mesh, with_tangents))
    return known[with_tangents]


def _boxes(corners: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return bounds (lo, hi) of triangles, grown so that a ray which runs along a side of a box is within it."""
    lo, hi = corners.min(1), corners.max(1)
    pad = np.maximum(hi, -lo).max(1, keepdims=True) * _BOX_PAD
    return lo - pad, hi + pad


def _leaf_blocks(corners: NDArray[np.float32], leaf_prims: NDArray[np.int32]) -> NDArray[np.float32]:
    """Lay the triangles of each leaf out side by side: (x0[4], y0[4], …, z2[4], prim[4])."""
    size = int(LEAF_SIZE)
    blocks = bvh.aligned(len(leaf_prims) * TRIANGLE_BLOCK.words).reshape(-1, TRIANGLE_BLOCK.words)
    filled = corners.reshape(-1, 9)[leaf_prims]  # -1 repeats the last triangle: never read, counts say how many
    blocks[:, :9 * size] = filled.transpose(0, 2, 1).reshape(-1, 9 * size)
    blocks[:, TRIANGLE_BLOCK.prim:] = leaf_prims.view(np.float32)
    return blocks


def _shading_arrays(mesh: Mesh, with_tangents: bool) -> tuple[NDArray[np.float32], NDArray[np.float32],
                                                              NDArray[np.int32]]:
    """Return (vertices, tangents, triangles)."""
    positions, triangles, normals, texcoords = mesh.positions, mesh.triangles, mesh.normals, mesh.texcoords
    tangents = np.empty((0, TANGENT.words), np.float32)
    if with_tangents and texcoords is not None:
        if normals is None:  # flat triangles: no two share a corner's normal
            corners = positions[triangles].astype(np.float64)
            face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            face /= np.maximum(np.linalg.norm(face, axis=1, keepdims=True), 1e-30)
            positions, texcoords = positions[triangles.ravel()], texcoords[triangles.ravel()]
            normals = np.repeat(face, 3, 0).astype(np.float32)
            triangles = np.arange(len(positions), dtype=np.int32).reshape(-1, 3)
        space = tangent_space(positions, triangles, normals, texcoords)
        positions, normals = positions[space.vertex_ids], normals[space.vertex_ids]
        texcoords, triangles, tangents = texcoords[space.vertex_ids], space.triangles, space.tangents
    vertices = np.zeros((len(positions), VERTEX.words), np.float32)
    vertices[:, VERTEX.position:VERTEX.normal] = positions
    if normals is not None:
        vertices[:, VERTEX.normal:VERTEX.texcoord] = _unit(normals)
    if texcoords is not None:
        vertices[:, VERTEX.texcoord:] = texcoords
    return vertices, np.ascontiguousarray(tangents), np.ascontiguousarray(triangles)


def _unit(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    wide = normals.astype(np.float64)
    wide /= np.maximum(np.linalg.norm(wide, axis=1, keepdims=True), 1e-300)
    return wide.astype(np.float32)


def mesh_tree(mesh: Mesh) -> bvh.WideTree:
    """Return the tree of a mesh that has been packed."""
    return next(iter(_PACKED[mesh].values())).tree
