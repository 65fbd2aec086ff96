"""The meshes of a scene in one set of arrays."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.layout import FACE, NO_TANGENTS, NODE, TANGENT, TRIANGLE, TRIANGLE_BLOCK, VERTEX, aligned
from glimt.packed.meshes import PackedMesh, pack_mesh, remember, shift_codes
from glimt.scene.mesh import Mesh

Words = NDArray[np.float32]

_KINDS = {"nodes": NODE, "blocks": TRIANGLE_BLOCK, "vertices": VERTEX, "tangents": TANGENT, "triangles": TRIANGLE,
          "faces": FACE}
"""The arrays of a `PackedMesh`."""


class MeshUse(NamedTuple):
    """A mesh as a scene uses it.

    with_tangents : bool
        Whether a normal map is seen on it.
    material_ids : tuple of int
        Of its materials, in the scene.
    """

    mesh: Mesh
    with_tangents: bool
    material_ids: tuple[int, ...]


class Placement(NamedTuple):
    """The INSTANCE fields that a mesh decides: where its arrays start, and what is in them."""

    root: int
    first_triangle: int
    tangent_shift: int
    flat: bool
    untextured: bool
    clear_unit: float


class Geometry(NamedTuple):
    """Arrays of a `PackedScene` that depend on meshes alone, and where in them each mesh is."""

    nodes: Words
    blocks: Words
    vertices: Words
    tangents: Words
    triangles: Words
    faces: Words
    placements: list[Placement]
    spans: list[tuple[int, int]]  # of each mesh, its first leaf block and how many there are
    clearances_found: list[bool]  # of each mesh


def join_meshes(uses: list[MeshUse], threads: int) -> Geometry:
    """Return the arrays of meshes, one behind the other.

    The arrays kept with each mesh become views into them, kind by kind, so that only one kind is held twice at a time.
    What is in use is never written to: another scene may hold it too.
    """
    packed = [pack_mesh(use.mesh, use.with_tangents, threads) for use in uses]
    starts, total = [], dict.fromkeys(_KINDS, 0)
    for mesh in packed:
        starts.append(total)
        total = {kind: before + getattr(mesh, kind).size // _KINDS[kind].words for kind, before in total.items()}
    joined = {kind: _join(kind, uses, packed, starts) for kind in _KINDS}
    return Geometry(**joined, placements=[
        Placement(start["nodes"], start["triangles"],
                  start["tangents"] - start["vertices"] if mesh.tangents.size else int(NO_TANGENTS),
                  use.mesh.normals is None and not mesh.tangents.size,  # tangents come with normals
                  use.mesh.texcoords is None, mesh.clear_unit)
        for use, mesh, start in zip(uses, packed, starts, strict=True)],
        spans=[(start["blocks"], mesh.blocks.size // TRIANGLE_BLOCK.words)
               for mesh, start in zip(packed, starts, strict=True)],
        clearances_found=[mesh.clearances_found for mesh in packed])


def _join(kind: str, uses: list[MeshUse], packed: list[PackedMesh], starts: list[dict[str, int]]) -> Words:
    """Return one kind of arrays joined; `packed` then holds views into it."""
    places = [_place(kind, use, start) for use, start in zip(uses, starts, strict=True)]
    if len(packed) == 1 and _is_whole(getattr(packed[0], kind)) and _is_at(packed[0], places[0]):
        return np.asarray(getattr(packed[0], kind))
    size = sum(getattr(mesh, kind).size for mesh in packed)
    joined, first = aligned(max(size, _KINDS[kind].words)), 0
    joined[size:] = 0  # no array may be empty: a record that is never read
    for k, (use, place) in enumerate(zip(uses, places, strict=True)):
        old, mesh = getattr(packed[k], kind), packed[k]
        part = joined[first:first + old.size]
        part[:] = old
        if not _is_at(mesh, place):
            _move(part, kind, use, mesh, place)
        place[kind] = part
        packed[k] = mesh._replace(**place)
        remember(use.mesh, packed[k])
        first += old.size
    return joined


def _place(kind: str, use: MeshUse, start: dict[str, int]) -> dict[str, Any]:
    """Return the fields of a `PackedMesh` that say what the indices in one kind of array count from."""
    if kind == "nodes":
        return {"first_node": start["nodes"], "first_block": start["blocks"]}
    if kind == "triangles":
        return {"first_vertex": start["vertices"], "material_ids": use.material_ids}
    return {}


def _is_at(mesh: PackedMesh, place: dict[str, Any]) -> bool:
    return all(getattr(mesh, field) == value for field, value in place.items())


def _is_whole(part: Words) -> bool:
    """Return whether an array is one that `aligned` made, not a part of a scene that may be gone."""
    return part.size > 0 and part.base is not None and part.base.nbytes == part.nbytes + 64


def _move(part: Words, kind: str, use: MeshUse, mesh: PackedMesh, place: dict[str, Any]) -> None:
    """Make the indices in a copied array count from where they start now."""
    if kind == "nodes":
        shift_codes(part, place["first_node"] - mesh.first_node, place["first_block"] - mesh.first_block)
    else:
        rows = part.view(np.int32).reshape(-1, TRIANGLE.words)
        rows[:, :TRIANGLE.material] += np.int32(place["first_vertex"] - mesh.first_vertex)
        material_ids = np.array(use.material_ids, np.int32)[use.mesh.material_ids]
        rows[:, TRIANGLE.material] = material_ids[mesh.numbers()]
