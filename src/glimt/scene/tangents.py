"""Tangent frames for normal maps, after MikkTSpace.

Normal maps are baked for the frames that Mikkelsen's code makes ("Simulation of Wrinkled Surfaces Revisited", 2008), so
this follows it: the tangent of a corner is the direction in which texcoord u grows, laid into the plane of the vertex
normal; corners of a vertex are averaged by angle; triangles that see the texture from behind are kept apart. It differs
in that vertices meet where they share an index, not where they happen to be equal, and in that triangles wound against
their normals get a frame that fits the texture.

A texcoord's v grows downwards in the image and a normal map's Y upwards: green up tilts the normal to where v falls.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class TangentSpace(NamedTuple):
    """Tangents, and what became of the vertices for their sake.

    vertex_ids : (k,) int32
        The vertex each new vertex is a copy of; the old ones come first, in order.
    triangles : (m, 3) int32
        Indices of new vertices.
    tangents : (k, 4) float32
        A unit tangent perpendicular to the normal, and w = ±1: ``bitangent = w * cross(normal, tangent)``.
    """

    vertex_ids: NDArray[np.int32]
    triangles: NDArray[np.int32]
    tangents: NDArray[np.float32]


class _Corners(NamedTuple):
    tangents: NDArray[np.float64]  # (m, 3, 3), as long as the corner's angle
    mirrored: NDArray[np.bool_]  # (m,)
    known: NDArray[np.bool_]  # (m,), False where the texcoords span no area


def tangent_space(positions: NDArray[np.float32], triangles: NDArray[np.int32], normals: NDArray[np.float32],
                  texcoords: NDArray[np.float32]) -> TangentSpace:
    """Return tangents, with a second vertex where triangles of either handedness meet.

    Triangles whose texcoords span no area take the frame of their neighbours; a vertex that has only such triangles
    gets any tangent.

    positions, normals : (n, 3) float32
    triangles : (m, 3) int32
    texcoords : (n, 2) float32
        (0, 0) is the top-left corner of the texture.
    """
    count = len(positions)
    corners = _corners(positions, triangles, normals, texcoords)
    plain = np.zeros(count, np.bool_)
    mirrored = np.zeros(count, np.bool_)
    plain[triangles[corners.known & ~corners.mirrored]] = True
    mirrored[triangles[corners.known & corners.mirrored]] = True
    split = np.flatnonzero(plain & mirrored)
    copies = np.arange(count, dtype=np.int32)
    copies[split] = np.arange(count, count + len(split))
    moved = (corners.known & corners.mirrored)[:, None]
    new_triangles = np.where(moved, copies[triangles], triangles).astype(np.int32)
    vertex_ids = np.concatenate([np.arange(count), split]).astype(np.int32)
    signs = np.where(mirrored & ~plain, -1.0, 1.0)[vertex_ids]
    signs[count:] = -1
    tangents = _sum_by_vertex(new_triangles, corners.tangents, len(vertex_ids))
    return TangentSpace(vertex_ids, new_triangles, _finish(tangents, normals[vertex_ids], signs))


def vertex_tangents(positions: NDArray[np.float32], triangles: NDArray[np.int32], normals: NDArray[np.float32],
                    texcoords: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return (n, 4) tangents without new vertices: where triangles of either handedness meet, the larger share wins.

    Arguments are those of `tangent_space`, w is its w.
    """
    corners = _corners(positions, triangles, normals, texcoords)
    mirrored = corners.mirrored[:, None, None]
    front = _sum_by_vertex(triangles, np.where(mirrored, 0, corners.tangents), len(positions))
    back = _sum_by_vertex(triangles, np.where(mirrored, corners.tangents, 0), len(positions))
    is_mirrored = np.linalg.norm(back, axis=1) > np.linalg.norm(front, axis=1)
    tangents = np.where(is_mirrored[:, None], back, front)
    return _finish(tangents, normals, np.where(is_mirrored, -1.0, 1.0))


def _corners(positions: NDArray[np.float32], triangles: NDArray[np.int32], normals: NDArray[np.float32],
             texcoords: NDArray[np.float32]) -> _Corners:
    points, places = positions.astype(np.float64)[triangles], texcoords.astype(np.float64)[triangles]
    edge1, edge2 = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    (u1, v1), (u2, v2) = (places[:, 1] - places[:, 0]).T, (places[:, 2] - places[:, 0]).T
    area = v1 * u2 - u1 * v2  # of the triangle in the texture, v turned up: positive where it is seen from the front
    unit_normals = _unit(normals)[triangles]
    faces_away = np.einsum("ij,ij->i", np.cross(edge1, edge2), unit_normals.sum(1)) < 0
    along_u = _unit((edge2 * v1[:, None] - edge1 * v2[:, None]) * np.sign(area)[:, None])
    tangents = _unit(_into_plane(along_u[:, None], unit_normals))
    tangents *= _angles(points, unit_normals)[..., None]
    return _Corners(tangents, (area < 0) != faces_away, (area != 0) & along_u.any(1))


def _angles(points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (m, 3) angles between a triangle's edges, as seen along each corner's normal."""
    ahead = _unit(_into_plane(np.roll(points, -1, 1) - points, normals))
    back = _unit(_into_plane(np.roll(points, 1, 1) - points, normals))
    angles: NDArray[np.float64] = np.arccos(np.einsum("ijk,ijk->ij", ahead, back).clip(-1, 1))
    return angles


def _unit(vectors: NDArray[Any]) -> NDArray[np.float64]:
    """Return (..., 3) vectors at unit length, zero ones as they are; products of coordinates fit into float64."""
    vectors = vectors.astype(np.float64, copy=False)
    length = np.sqrt(np.einsum("...k,...k->...", vectors, vectors))
    unit: NDArray[np.float64] = vectors / np.where(length > 0, length, 1)[..., None]
    return unit


def _into_plane(vectors: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (..., 3) vectors without their part along unit normals; 0 where nothing but rounding is left."""
    along = np.einsum("...k,...k->...", vectors, normals)[..., None]
    flat: NDArray[np.float64] = vectors - normals * along
    return np.where(np.abs(flat).max(-1, keepdims=True) > 1e-12 * np.abs(along), flat, 0.0)


def _sum_by_vertex(triangles: NDArray[np.int32], values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return (count, 3) sums over the corners (m, 3, 3) at each vertex."""
    ids = triangles.reshape(-1)
    return np.stack([np.bincount(ids, values[..., k].reshape(-1), count) for k in range(3)], 1)


def _finish(tangents: NDArray[np.float64], normals: NDArray[np.float32],
            signs: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return (k, 4) float32: unit tangents in the plane of the normals, any one where there is none, and the signs."""
    unit_normals = _unit(normals)
    unit = _unit(_into_plane(_unit(tangents), unit_normals))
    lost = np.flatnonzero(~unit.any(1))
    if len(lost):
        axis = np.eye(3)[np.abs(unit_normals[lost]).argmin(1)]
        unit[lost] = _unit(_into_plane(axis, unit_normals[lost]))
    return np.column_stack([unit, signs]).astype(np.float32)
