"""Meshes of the example scenes, in metres, +Y up, counter-clockwise from the front."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Patch(NamedTuple):
    """Polygons of one material; corners share vertices where normals and texcoords agree."""

    material: str
    positions: Array
    """(n, 3)"""
    normals: Array
    """(n, 3), unit length"""
    texcoords: Array
    """(n, 2), (0, 0) at the bottom left as OBJ has it"""
    polygons: Array
    """(m, 3 or 4) vertex numbers"""


def panel(material: str, corner: ArrayLike, right: ArrayLike, up: ArrayLike, tile: float,
          offset: tuple[float, float] = (0, 0)) -> Patch:
    """Return a rectangle whose front shows `right` to the right; its texture repeats every `tile` metres."""
    corner, right, up = (np.asarray(v, np.float64) for v in (corner, right, up))
    positions = corner + np.array([0 * right, right, right + up, up])
    width, height = np.linalg.norm(right) / tile, np.linalg.norm(up) / tile
    texcoords = np.array([(0, 0), (width, 0), (width, height), (0, height)]) + offset
    normal = np.cross(right, up)
    return Patch(material, positions, np.tile(normal / np.linalg.norm(normal), (4, 1)), texcoords,
                 np.array([(0, 1, 2, 3)]))


def block(material: str, tile: float = 1) -> list[Patch]:
    """Return the cube from (-1/2, 0, -1/2) to (1/2, 1, 1/2): 12 triangles to be scaled into beams and plinths."""
    a, b = -0.5, 0.5
    return [panel(material, corner, right, up, tile) for corner, right, up in [
        ((a, 0, b), (1, 0, 0), (0, 1, 0)), ((b, 0, a), (-1, 0, 0), (0, 1, 0)),
        ((b, 0, b), (0, 0, -1), (0, 1, 0)), ((a, 0, a), (0, 0, 1), (0, 1, 0)),
        ((a, 1, b), (1, 0, 0), (0, 0, -1)), ((a, 0, a), (1, 0, 0), (0, 0, 1))]]


def prism(material: str, profile: Sequence[tuple[float, float]], sides: int, tile: float = 1) -> list[Patch]:
    """Return a flat-sided solid around +Y with a lid; `profile` is (radius, height) from the bottom up."""
    angles = (np.arange(sides + 1) + 0.5) * 2 * np.pi / sides
    rim = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], -1)
    patches, v = [], 0.0
    for (r0, y0), (r1, y1) in pairwise(profile):
        slant = np.hypot(r1 - r0, y1 - y0)
        for side in range(sides):
            left, right = rim[side], rim[side + 1]
            corners = np.array([r0 * left, r0 * right, r1 * right, r1 * left]) + np.outer([y0, y0, y1, y1], (0, 1, 0))
            # One texture scale for all bands, so that widths are right and edges meet in the middle of a side.
            half = np.linalg.norm(right - left) / 2
            texcoords = np.array([(-r0 * half, v), (r0 * half, v), (r1 * half, v + slant), (-r1 * half, v + slant)])
            normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
            patches.append(Patch(material, corners, np.tile(normal / np.linalg.norm(normal), (4, 1)),
                                 texcoords / tile + (side * 0.37, 0), np.array([(0, 1, 2, 3)])))
        v += slant
    radius, top = profile[-1]
    lid = rim[:-1] * radius + (0, top, 0)
    fan = np.array([(0, i, i + 1) for i in range(1, sides - 1)])
    patches.append(Patch(material, lid, np.tile((0.0, 1, 0), (sides, 1)), lid[:, ::2] * (1, -1) / tile, fan))
    return patches


def gem(material: str, subdivisions: int = 1) -> list[Patch]:
    """Return a faceted sphere of radius 1: an icosahedron whose triangles are split in four `subdivisions` times."""
    g = (1 + 5**0.5) / 2
    corners = np.array([(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
                        (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)])
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
             (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    triangles = corners[np.array(faces)] / np.hypot(1, g)
    for _ in range(subdivisions):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        ab, bc, ca = (m / np.linalg.norm(m, axis=-1, keepdims=True) for m in (a + b, b + c, c + a))
        triangles = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals = np.repeat(normals / np.linalg.norm(normals, axis=-1, keepdims=True), 3, 0)
    count = len(normals)
    texcoords = np.tile([(0.0, 0), (1, 0), (0.5, 1)], (count // 3, 1))
    return [Patch(material, triangles.reshape(-1, 3), normals, texcoords, np.arange(count).reshape(-1, 3))]


def torus(material: str, radius: float, tube: float, around: int, across: int) -> list[Patch]:
    """Return a smooth ring around +Y whose tube has its middle at `radius`."""
    u, v = (np.linspace(0, 1, n + 1) for n in (around, across))
    a, b = (grid * 2 * np.pi for grid in np.meshgrid(u, v, indexing="ij"))
    normals = np.stack([np.cos(b) * np.sin(a), np.sin(b), np.cos(b) * np.cos(a)], -1)
    positions = tube * normals + radius * np.stack([np.sin(a), 0 * a, np.cos(a)], -1)
    return [_grid(material, positions, normals, np.stack(np.meshgrid(u, v, indexing="ij"), -1))]


def petal(material: str, along: int = 12, across: int = 8) -> list[Patch]:
    """Return a petal from the origin to about +X, cupped and bent upwards, a closed and slightly twisted shell."""
    s, t = np.meshgrid(np.linspace(0, 1, along + 1), np.linspace(0, 1, across + 1), indexing="ij")
    width = 0.19 * np.sin(np.pi * s**0.9) + 0.03 * (1 - s) + 0.003
    a, b = np.cos(2 * np.pi * t), np.sin(2 * np.pi * t)
    z = width * a
    positions = np.stack([s - 0.2 * a * a * s * (1 - s), 0.22 * s * s + 0.7 * z * z + 0.10 * width * b + 0.06 * s * z,
                          -z + 0.05 * np.sin(np.pi * s)], -1)
    normals = _smooth_normals(positions)
    return [_grid(material, positions, normals, np.stack([t, s], -1))]


def _grid(material: str, positions: Array, normals: Array, texcoords: Array) -> Patch:
    """Return a patch of quads from (rows, columns, …) arrays; its front is where columns × rows points."""
    rows, columns = positions.shape[:2]
    at = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], -1)
    return Patch(material, positions.reshape(-1, 3), normals.reshape(-1, 3), texcoords.reshape(-1, 2),
                 quads.reshape(-1, 4))


def _smooth_normals(positions: Array) -> Array:
    """Return normals of a grid (rows, columns, 3) whose last column lies on its first: means over the quads around."""
    quads = np.cross(positions[1:, 1:] - positions[:-1, :-1], positions[:-1, 1:] - positions[1:, :-1])
    normals = np.zeros_like(positions)
    for corner in (normals[:-1, :-1], normals[1:, :-1], normals[:-1, 1:], normals[1:, 1:]):
        corner += quads
    normals[:, [0, -1]] = (normals[:, 0] + normals[:, -1])[:, None]
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)
