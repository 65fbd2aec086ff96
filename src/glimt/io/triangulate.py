"""Faces of any number of corners to triangles."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.io.obj_kernels import clip_ears

BUDGET = 3 * 10**8
"""Steps of ear clipping per call, a few seconds; concave faces beyond it are cut without looking."""

_FLAT = 1e-12  # of the product of two edges: a height that float64 cannot tell from zero


class Triangles(NamedTuple):
    """Triangles as rows of the corners they were cut from.

    corners : (m, 3) int64
    faces : (m,) int64
        The face each triangle is a part of.
    complete : bool
        False where `BUDGET` was spent.
    """

    corners: NDArray[np.int64]
    faces: NDArray[np.int64]
    complete: bool


def triangulate(positions: NDArray[np.float32], starts: NDArray[np.int64]) -> Triangles:
    """Cut faces into corners - 2 triangles each: a fan where that covers the face, else by clipping ears.

    positions : (n, 3) float32
        Position of each corner.
    starts : (faces + 1,) int64
        Face i has the corners from starts[i] up to starts[i + 1], at least 3.
    """
    sizes = np.diff(starts)
    faces = np.repeat(np.arange(len(sizes)), sizes - 2)
    first_rows = np.cumsum(sizes - 2) - (sizes - 2)
    second = np.arange(len(faces)) - first_rows[faces] + starts[:-1][faces] + 1
    corners = np.stack([starts[:-1][faces], second, second + 1], 1)
    if len(faces) == len(sizes):
        return Triangles(corners, faces, True)
    normals = doubled_areas(positions, corners)
    face_normals = np.add.reduceat(normals, first_rows)  # Newell's
    agree = np.einsum("ij,ij->i", normals, face_normals[faces]) > 0
    is_fan = np.logical_and.reduceat(agree, first_rows) | (sizes == 3) | ~face_normals.any(1)
    if is_fan.all():
        return Triangles(corners, faces, True)
    concave = np.flatnonzero(~is_fan)
    ears, complete = _clip(positions, starts, concave, face_normals[concave])
    corners[~is_fan[faces]] = ears
    return Triangles(corners, faces, complete)


def doubled_areas(positions: NDArray[np.float32], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Return (m, 3) normals of twice the triangles' areas, right-handed."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    areas: NDArray[np.float64] = np.cross(b - a, c - a)
    return areas


def has_area(positions: NDArray[np.float32], triangles: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Return (m,) whether each triangle has three different corners that lie on no line."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    u, v = b - a, c - a
    large_enough: NDArray[np.bool_] = squares(np.cross(u, v)) > _FLAT**2 * squares(u) * squares(v)
    return large_enough


def squares(vectors: NDArray[Any]) -> NDArray[np.float64]:
    """Return (m,) squared lengths of (m, 3) vectors."""
    result: NDArray[np.float64] = np.einsum("ij,ij->i", vectors, vectors)
    return result


def _clip(positions: NDArray[np.float32], starts: NDArray[np.int64], chosen: NDArray[np.int64],
          normals: NDArray[np.float64]) -> tuple[NDArray[np.int64], bool]:
    """Clip the ears of the `chosen` faces; return their triangles, face after face, and whether the budget lasted."""
    sizes = np.diff(starts)[chosen]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    owner = np.repeat(np.arange(len(chosen)), sizes)
    rows = np.arange(ends[-1]) - ends[owner] + starts[chosen][owner]
    axis = np.abs(normals).argmax(1)  # looked at along this one; the other two in the order that keeps the turn left
    swap = normals[np.arange(len(chosen)), axis] < 0
    right, up = np.where(swap, axis + 2, axis + 1) % 3, np.where(swap, axis + 1, axis + 2) % 3
    points = np.stack([positions[rows, right[owner]], positions[rows, up[owner]]], 1).astype(np.float64)
    ears = np.empty((len(points) - 2 * len(chosen), 3), np.int64)
    steps = clip_ears(points, ends, ears, BUDGET, np.empty((4, len(points)), np.int64))
    return rows[ears], steps <= BUDGET
