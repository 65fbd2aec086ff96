"""One mesh as arrays: its tree, its triangles in leaf blocks, and what shading needs."""

from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from glimt import bvh
from glimt.layout import (
    FACE,
    LEAF_SIZE,
    LEAF_STEP,
    NODE,
    TANGENT,
    TRIANGLE,
    TRIANGLE_BLOCK,
    VERTEX,
    aligned,
    aligned_copy,
    dtype,
)
from glimt.scene.mesh import Mesh
from glimt.scene.tangents import tangent_space

_BOX_PAD = np.float32(2.0**-21)
"""As a share of a triangle's largest coordinate: eight times what float32 rounds off."""
CLEAR_UNIT = 2.0**-20
"""The unit of clearances as a share of the mesh's size."""
_LEAST_TRIANGLES = 512
"""A ray that leaves a smaller mesh has soon met all of it anyway: nothing is known of its clearances."""
_SAMPLES = 4096  # triangles by which a mesh's side is chosen
_CHUNK = 1 << 15  # leaf blocks filled at a time: bounds what that takes beside the blocks

Words = NDArray[np.float32]


class PackedMesh(NamedTuple):
    """Arrays of one mesh, as the words that a `PackedScene` has, and where in a scene's arrays they start.

    Once the mesh has been joined with others these are views into the scene's arrays: nothing is held twice.

    nodes : NODE words
        Child codes count from `first_node` nodes and `first_block` blocks before.
    blocks : TRIANGLE_BLOCK words
    vertices : VERTEX words
    tangents : TANGENT words, none for a mesh that needs none
    triangles : TRIANGLE words
        In the order of the leaves, as vertices are in that of the triangles: what is seen side by side lies close
        together. Vertices count from `first_vertex` vertices before; `material_ids` are those of the mesh's materials.
    faces : FACE words
        For clearances see `clearance.ClearanceFinder`.
    clear_unit : float
        The unit of their distances, below 0 if they are those of the clockwise side of triangles.
    depth : int
        Of the tree.
    with_tangents : bool
        Whether tangents were asked for.
    clearances_found : bool
    """

    nodes: Words
    blocks: Words
    vertices: Words
    tangents: Words
    triangles: Words
    faces: Words
    clear_unit: float
    first_node: int
    first_block: int
    first_vertex: int
    material_ids: tuple[int, ...]
    depth: int
    with_tangents: bool
    clearances_found: bool = False

    def tree(self) -> bvh.WideTree:
        """Return the tree of the mesh, as if it stood alone."""
        nodes = aligned_copy(self.nodes)
        shift_codes(nodes, -self.first_node, -self.first_block)
        prims = self.blocks.view(np.int32).reshape(-1, TRIANGLE_BLOCK.words)[:, TRIANGLE_BLOCK.prim:]
        return bvh.WideTree(nodes, np.where(prims >= 0, self.numbers()[prims], np.int32(-1)), self.depth)

    def numbers(self) -> NDArray[np.int32]:
        """Return which triangle of the mesh each packed one is."""
        numbers: NDArray[np.int32] = self.faces.view(dtype(FACE))["number"]
        return numbers


_PACKED: "WeakKeyDictionary[Mesh, PackedMesh]" = WeakKeyDictionary()


def pack_mesh(mesh: Mesh, with_tangents: bool, threads: int) -> PackedMesh:
    """Return the arrays of a mesh, which are kept as long as it lives."""
    packed = _PACKED.get(mesh)
    if packed is None:
        tree = _tree(mesh, threads)
        numbers = tree.leaf_prims[tree.leaf_prims >= 0]
        packed = PackedMesh(tree.nodes, _leaf_blocks(mesh, tree.leaf_prims),
                            *_shading_arrays(mesh, with_tangents, numbers), _faces(numbers),
                            _clear_unit(mesh), 0, 0, 0, tuple(range(len(mesh.materials))), tree.depth, with_tangents)
        mesh.moved_from = None
        remember(mesh, packed)
    elif packed.with_tangents != with_tangents:
        vertices, tangents, triangles = _shading_arrays(mesh, with_tangents, packed.numbers())
        packed = packed._replace(vertices=vertices, tangents=tangents, triangles=triangles, first_vertex=0,
                                 material_ids=tuple(range(len(mesh.materials))), with_tangents=with_tangents)
        remember(mesh, packed)
    return packed


def _tree(mesh: Mesh, threads: int) -> bvh.WideTree:
    """Return a new tree, or that of the mesh which this one was before its vertices moved, fitted to it."""
    before = _PACKED.get(mesh.moved_from) if mesh.moved_from else None
    return bvh.refit(before.tree(), *_boxes(mesh)) if before else bvh.build(*_boxes(mesh), threads)


def remember(mesh: Mesh, packed: PackedMesh) -> None:
    """Keep `packed` as the arrays of a mesh."""
    _PACKED[mesh] = packed


def mesh_tree(mesh: Mesh) -> bvh.WideTree:
    """Return the tree of a mesh that has been packed."""
    return _PACKED[mesh].tree()


def note_clearances(mesh: Mesh, words: NDArray[Any]) -> None:
    """Keep that all clearances of a mesh are found, if they are a part of these and not a copy made before."""
    packed = _PACKED.get(mesh)
    if packed is not None and np.may_share_memory(packed.faces, words):
        remember(mesh, packed._replace(clearances_found=True))


def shift_codes(nodes: Words, nodes_before: int, blocks_before: int) -> None:
    """Make a tree's child codes count from that many nodes and blocks further ahead."""
    codes = nodes.view(np.int32).reshape(-1, NODE.words)[:, NODE.child:NODE.order]
    codes += np.where(codes >= 0, np.int32(nodes_before), np.int32(-blocks_before * LEAF_STEP))


def _boxes(mesh: Mesh) -> tuple[Words, Words]:
    """Return bounds (lo, hi) of triangles, grown so that a ray which runs along a side of a box is within it."""
    a, b, c = mesh.triangles.T
    lo, hi = mesh.positions[a], mesh.positions[a]
    for corner in (b, c):
        points = mesh.positions[corner]
        np.minimum(lo, points, out=lo)
        np.maximum(hi, points, out=hi)
    pad = np.maximum(hi, -lo).max(1, keepdims=True) * _BOX_PAD
    lo -= pad
    hi += pad
    return lo, hi


def _leaf_blocks(mesh: Mesh, leaf_prims: NDArray[np.int32]) -> Words:
    """Lay the triangles of each leaf out side by side: (x0[4], y0[4], …, z2[4], prim[4])."""
    size = int(LEAF_SIZE)
    blocks = aligned(len(leaf_prims) * TRIANGLE_BLOCK.words)
    rows = blocks.reshape(-1, TRIANGLE_BLOCK.words)
    for first in range(0, len(rows), _CHUNK):
        prims = leaf_prims[first:first + _CHUNK]  # -1 repeats the last triangle: never read, counts say how many
        corners = mesh.positions[mesh.triangles[prims]].reshape(-1, size, 9)
        rows[first:first + _CHUNK, :9 * size] = corners.transpose(0, 2, 1).reshape(-1, 9 * size)
    used = leaf_prims >= 0
    place = np.cumsum(used.ravel(), dtype=np.int32).reshape(-1, size) - np.int32(1)
    rows[:, TRIANGLE_BLOCK.prim:] = np.where(used, place, np.int32(-1)).view(np.float32)
    return blocks


def _shading_arrays(mesh: Mesh, with_tangents: bool, numbers: NDArray[np.int32]) -> tuple[Words, Words, Words]:
    """Return (vertices, tangents, triangles), these in the order of `numbers`; materials count within the mesh."""
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
    used, triangles = _by_first_use(triangles[numbers], len(positions))
    vertices = aligned(len(used) * VERTEX.words)
    rows = vertices.reshape(-1, VERTEX.words)
    rows[:, VERTEX.position:VERTEX.normal] = positions[used]
    rows[:, VERTEX.normal:VERTEX.texcoord] = 0 if normals is None else _unit(normals[used])
    rows[:, VERTEX.texcoord:] = 0 if texcoords is None else texcoords[used]
    if len(tangents):
        tangents = tangents[used]
    assert mesh.material_ids is not None  # a constructor's None means zeros
    corner_ids = aligned(len(triangles) * TRIANGLE.words, np.int32)
    corner_ids.reshape(-1, TRIANGLE.words)[:, :TRIANGLE.material] = triangles
    corner_ids.reshape(-1, TRIANGLE.words)[:, TRIANGLE.material] = mesh.material_ids[numbers]
    return vertices, np.ascontiguousarray(tangents).ravel(), corner_ids.view(np.float32)


def _by_first_use(triangles: NDArray[np.int32], count: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return those of `count` vertices that triangles use, in the order in which they do, and triangles of these."""
    corners, first_use = triangles.ravel(), np.full(count, -1, np.int64)
    first_use[corners[::-1]] = np.arange(len(corners) - 1, -1, -1)  # what is written last stays
    is_first = np.zeros(len(corners), bool)
    is_first[first_use[first_use >= 0]] = True
    used, place = corners[is_first], np.empty(count, np.int32)
    place[used] = np.arange(len(used), dtype=np.int32)
    return used, place[triangles]


def _unit(normals: Words) -> Words:
    wide = normals.astype(np.float64)
    wide /= np.maximum(np.linalg.norm(wide, axis=1, keepdims=True), 1e-300)
    return wide.astype(np.float32)


def _faces(numbers: NDArray[np.int32]) -> Words:
    """Return the FACE records; no clearance is known yet."""
    words = aligned(len(numbers) * FACE.words)
    faces = words.view(dtype(FACE))
    faces["number"], faces["clearance"] = numbers, 0
    return words


def _clear_unit(mesh: Mesh) -> float:
    """Return the unit of a mesh's clearances, below 0 if they are those of the clockwise side of its triangles.

    It is the side of its normals, if it has any. 0 for a mesh that gets none.
    """
    if len(mesh.triangles) < _LEAST_TRIANGLES:
        return 0.0
    lo, hi = mesh.bounds()
    unit = float((hi - lo).max()) * CLEAR_UNIT
    if mesh.normals is None:
        return unit
    some = mesh.triangles[::len(mesh.triangles) // _SAMPLES + 1]
    a, b, c = (mesh.positions[some[:, k]].astype(np.float64) for k in range(3))
    agree = (np.cross(b - a, c - a) * mesh.normals[some[:, 0]]).sum(1)
    return unit if np.sign(agree).sum() >= 0 else -unit
