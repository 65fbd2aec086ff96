"""One shape with fewer or more triangles."""

from typing import Any

import numpy as np

from glimt.scene.mesh import Mesh


def subdivided(mesh: Mesh) -> Mesh:
    """Return the same surface with each triangle cut into four at the middles of its edges."""
    count = len(mesh.positions)
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), 1).astype(np.int64)
    keys, numbers = np.unique(edges[:, 0] * count + edges[:, 1], return_inverse=True)
    ends = keys // count, keys % count
    a, b, c = mesh.triangles.T
    ab, bc, ca = (count + numbers.reshape(-1, 3)).T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    triangles = np.concatenate([np.stack(three, -1) for three in corners])
    ids = None if mesh.material_ids is None else np.tile(mesh.material_ids, 4)
    return Mesh(_with_middles(mesh.positions, ends), triangles, _with_middles(mesh.normals, ends),
                _with_middles(mesh.texcoords, ends), mesh.materials, ids, name=mesh.name)


def _with_middles(values: Any, ends: tuple[Any, Any]) -> Any:
    """Return the values of vertices with those of the middles of edges behind them."""
    return None if values is None else np.concatenate([values, (values[ends[0]] + values[ends[1]]) / 2])


def clustered(mesh: Mesh, cells: int) -> Mesh:
    """Return a coarser mesh: all vertices in a cell of a grid become their mean, and flattened triangles go.

    `cells` are along the longest side of the box (Rossignac and Borrel, "Multi-resolution 3D approximations for
    rendering complex scenes", 1993).
    """
    lo, hi = (bound.astype(np.float64) for bound in mesh.bounds())
    cell = np.minimum((mesh.positions - lo) * (cells / (hi - lo).max()), cells - 1).clip(0).astype(np.int64)
    _, numbers = np.unique((cell * (1, cells, cells * cells)).sum(1), return_inverse=True)
    sums = np.stack([np.bincount(numbers, axis) for axis in mesh.positions.astype(np.float64).T], -1)
    means = sums / np.bincount(numbers)[:, None]
    triangles = numbers.reshape(-1)[mesh.triangles]
    whole = (triangles != np.roll(triangles, 1, 1)).all(1)
    _, once = np.unique(np.sort(triangles[whole], 1), axis=0, return_index=True)
    return Mesh(means.astype(np.float32), triangles[whole][np.sort(once)], name=mesh.name)


def sizes(mesh: Mesh, least: int, most: int) -> list[Mesh]:
    """Return versions of a mesh with about 4 times the triangles each, from `least` to `most`, itself among them.

    Clustering makes the smaller ones, cutting each triangle in four the larger ones: all have the same shape.
    """
    coarse, cells = [], 2
    while cells <= 1024:
        smaller = clustered(mesh, cells)
        if len(smaller.triangles) > len(mesh.triangles) / 2:
            break
        if len(smaller.triangles) >= least:
            coarse.append(smaller)
        cells *= 2
    fine = [mesh]
    while 4 * len(fine[-1].triangles) <= most:
        fine.append(subdivided(fine[-1]))
    return coarse + fine
