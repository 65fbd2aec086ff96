"""Closed meshes of any fineness."""

import numpy as np

from glimt import linalg
from glimt.scene.mesh import Mesh

FAR_AWAY = linalg.compose(linalg.translation((-1000, 300, 700)), linalg.rotation((1, 2, 3), 40),
                          linalg.scaling((-0.3, 2, 5)), linalg.rotation((3, -1, 1), 70))
"""Turned, stretched, mirrored, turned again, and a thousand units from the origin."""

MATRICES = {"modelled there": linalg.identity(), "far away": FAR_AWAY}


def icosphere(levels, roughness=0.0, seed=0):
    """Return a closed mesh of 20 * 4**levels triangles around the origin, radius 1 give or take `roughness`."""
    golden = (1 + 5**0.5) / 2
    points = np.array([(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden),
                       (0, 1, golden), (0, -1, -golden), (0, 1, -golden), (golden, 0, -1), (golden, 0, 1),
                       (-golden, 0, -1), (-golden, 0, 1)])
    faces = np.array([(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                      (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
                      (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)])
    for _ in range(levels):
        edges = np.sort(np.stack([faces, np.roll(faces, -1, 1)], 2).reshape(-1, 2), 1)
        unique, ids = np.unique(edges, axis=0, return_inverse=True)
        middle = len(points) + ids.reshape(-1, 3)  # of edges ab, bc, ca
        points = np.concatenate([points, points[unique].mean(1)])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        faces = np.concatenate([np.stack(corners, 1) for corners in
                                ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    points = linalg.normalize(points)
    return Mesh(points * np.random.default_rng(seed).uniform(1 - roughness, 1 + roughness, (len(points), 1)), faces)


def torus(around=96, across=48, jitter=0.0, seed=0):
    """Return a closed mesh: a tube of radius 0.4 around a circle of radius 1 about +Y; `jitter` moves vertices."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    reach = 1 + 0.4 * np.cos(v)
    points = np.stack([reach * np.cos(u), 0.4 * np.sin(v), reach * np.sin(u)], -1).reshape(-1, 3)
    points += np.random.default_rng(seed).uniform(-jitter, jitter, points.shape)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    return Mesh(points, np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]))


def edges(mesh):
    """Return the (n, 2) vertex pairs of a closed mesh, each edge once."""
    pairs = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, 1)], 2).reshape(-1, 2)
    return np.unique(np.sort(pairs, 1), axis=0)


UNEVEN = {"sphere": lambda: icosphere(4, roughness=0.04), "torus": lambda: torus(64, 32, jitter=0.01)}
"""Thousands of triangles without any symmetry left."""


def inner_points(mesh, random, count):
    """Return (count, 3) points well inside: near the middle of the sphere, in the tube of the torus."""
    if abs(mesh.positions).max() < 1.1:
        return random.uniform(-0.4, 0.4, (count, 3))
    angle = random.uniform(0, 2 * np.pi, count)
    circle = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], 1)
    return circle + random.uniform(-0.15, 0.15, (count, 3))


def rays_in_coordinate_planes(random, count):
    """Return (origins, directions) of rays from near 0 with some coordinates 0, of either sign."""
    origins = random.uniform(-0.5, 0.5, (count, 3)) * random.integers(0, 2, (count, 3))
    directions = random.standard_normal((count, 3)) * random.integers(0, 2, (count, 3))
    directions[~directions.any(1), 0] = -1
    directions[directions == 0] *= random.choice([-1.0, 1.0], (directions == 0).sum())
    return origins, directions
