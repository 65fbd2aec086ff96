"""Shading normals for a file that gives none: by smoothing group, or by the angle between faces."""

import secrets
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.io.obj_kernels import first_rows, smooth_corners
from glimt.io.triangulate import doubled_areas, squares

CREASE_DEG = 60.0
"""Faces that meet at a larger angle have an edge between them, where a file has no smoothing groups."""


def unique_rows(rows: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return (ids, firsts) of (n, 3) rows: row i equals row ``firsts[ids[i]]``, ids in order of first appearance."""
    table = np.full(2 << len(rows).bit_length(), -1, np.int32)
    ids, firsts = np.empty(len(rows), np.int32), np.empty(len(rows), np.int32)
    count = first_rows(np.ascontiguousarray(rows, np.int32), np.uint64(secrets.randbits(64)), table, ids, firsts)
    return ids, firsts[:count]


def weld(positions: NDArray[np.float32]) -> NDArray[np.int32]:
    """Return (n,) ids: the same for vertices at the same place."""
    return unique_rows((positions + np.float32(0)).view(np.int32))[0]  # + 0: -0.0 lies at 0.0


def labels_by_group(vertices: NDArray[np.int32], faces: NDArray[np.int64],
                    groups: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return (3m,) labels of corners that share a normal: those of one vertex and group, or of one face in group 0.

    vertices : (m, 3) int32; faces, groups : (m,) int64
    """
    off = (groups == 0)[:, None]
    keys = np.stack([np.where(off, -1, vertices), np.broadcast_to(np.where(groups == 0, faces, groups)[:, None],
                                                                 vertices.shape),
                     np.zeros_like(vertices)], -1)
    return unique_rows(keys.reshape(-1, 3).astype(np.int32))[0]


def labels_by_angle(vertices: NDArray[np.int32], normals: NDArray[np.float64],
                    crease_deg: float = CREASE_DEG) -> NDArray[np.int32]:
    """Return (3m,) labels of corners that share a normal: those of one vertex that no crease divides.

    vertices : (m, 3) int32; normals : (m, 3) float64, unit
    """
    start, end = vertices.reshape(-1), np.roll(vertices, -1, 1).reshape(-1)
    edges, _ = unique_rows(np.stack([np.minimum(start, end), np.maximum(start, end), np.zeros_like(start)], 1))
    labels, latest = np.arange(len(start), dtype=np.int32), np.full(len(start), -1, np.int32)
    smooth_corners(np.ascontiguousarray(start), edges, normals, float(np.cos(np.radians(crease_deg))), labels, latest)
    return labels


def smooth_normals(positions: NDArray[np.float32], triangles: NDArray[np.int32], faces: NDArray[np.int64],
                   groups: NDArray[np.int64] | None) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return (m, 3) indices of normals, one for each corner, and the (k, 3) unit normals.

    A normal is the mean of its triangles' normals, weighted by their angles at the vertex (Thürmer and Wüthrich,
    "Computing vertex normals from polygonal facets", 1998).

    positions : (n, 3) float32
    triangles : (m, 3) int32
        Each with an area.
    faces, groups : (m,) int64
        The face and smoothing group of each triangle; no groups: smooth where faces meet below `CREASE_DEG`.
    """
    areas = doubled_areas(positions, triangles)
    normals = _unit(areas)
    vertices = weld(positions)[triangles]
    labels = labels_by_angle(vertices, normals) if groups is None else labels_by_group(vertices, faces, groups)
    weights = _angles(positions, triangles, areas).reshape(-1)
    corner_normals = np.repeat(normals, 3, 0)
    sums = np.stack([np.bincount(labels, weights * corner_normals[:, k]) for k in range(3)], 1)
    total = np.bincount(labels, weights)
    cancelled = squares(sums) <= 1e-12 * total**2
    if (cancelled & (total > 0)).any():  # faces back to back: one of them decides
        hit = cancelled[labels]
        sums[labels[hit]] = corner_normals[hit]
    return labels.reshape(-1, 3), _unit(sums).astype(np.float32)


def _unit(vectors: NDArray[Any]) -> NDArray[np.float64]:
    """Return (m, 3) vectors at unit length, zero ones as they are; squares of areas fit into float64."""
    length = np.sqrt(squares(vectors))
    unit: NDArray[np.float64] = vectors / np.where(length > 0, length, 1)[:, None]
    return unit


def _angles(positions: NDArray[np.float32], triangles: NDArray[np.int32],
            areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (m, 3) angles of triangles in radians."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    double_area = np.sqrt(squares(areas))
    cosines = [np.einsum("ij,ij->i", u, v) for u, v in ((b - a, c - a), (c - b, a - b), (a - c, b - c))]
    return np.stack([np.arctan2(double_area, cosine) for cosine in cosines], 1)
