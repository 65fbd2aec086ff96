"""No ray leaves a closed mesh unseen: not between triangles, not at a corner, not in an instance far away."""

import numpy as np
import pytest

import closed_meshes
import tracing
from closed_meshes import MATRICES, inner_points
from glimt import linalg
from glimt.packed import pack
from glimt.scene.instance import Instance
from glimt.scene.scene import Scene

BATCH = 500_000


@pytest.fixture(scope="module", params=closed_meshes.UNEVEN)
def mesh(request):
    """Thousands of triangles without any symmetry left."""
    return closed_meshes.UNEVEN[request.param]()


def escaped(packed, origins, directions):
    """Return how many rays meet nothing, by either way of asking."""
    hits = tracing.closest(packed, origins, directions)
    return int((~(hits.t < np.inf)).sum()), int((~tracing.blocked(packed, origins, directions)).sum())


def placed(mesh, matrix):
    return pack(Scene().add(Instance(mesh, matrix)))


@pytest.mark.parametrize("place", MATRICES)
def test_random_rays_do_not_escape(mesh, place):
    """2.5 million for each of the four: 10 million."""
    matrix, random = MATRICES[place], np.random.default_rng(5)
    packed = placed(mesh, matrix)
    for _ in range(5):
        origins = linalg.transform_points(matrix, inner_points(mesh, random, BATCH))
        directions = random.standard_normal((BATCH, 3), np.float32)
        hits = tracing.closest(packed, origins, directions)
        assert (hits.t < np.inf).all()


@pytest.mark.parametrize("place", MATRICES)
def test_rays_at_vertices_and_edges_do_not_escape(mesh, place):
    """At each vertex and at the middle of each edge, as exactly as float32 can aim: 1 million in all."""
    matrix, random = MATRICES[place], np.random.default_rng(6)
    middles = mesh.positions[closed_meshes.edges(mesh)].mean(1, dtype=np.float64)
    targets = np.concatenate([mesh.positions, middles])
    targets = np.tile(targets, (125_000 // len(targets) + 1, 1))
    for origin in (linalg.transform_points(matrix, inner_points(mesh, random, len(targets))),
                   linalg.transform_points(matrix, inner_points(mesh, random, 1)[0])):  # apart, and from one point
        origin = origin.astype(np.float32)
        directions = linalg.transform_points(matrix, targets) - origin
        assert escaped(placed(mesh, matrix), origin, directions) == (0, 0)


@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1.0, 1e5, 1e12])
def test_size_does_not_matter(scale):
    mesh, random = closed_meshes.icosphere(3, roughness=0.04), np.random.default_rng(7)
    for packed in (placed(mesh, linalg.scaling(scale)),
                   pack(Scene().add(type(mesh)(mesh.positions * np.float64(scale), mesh.triangles)))):
        origins = inner_points(mesh, random, 50_000) * scale
        targets = mesh.positions[random.integers(len(mesh.positions), size=50_000)] * scale
        assert escaped(packed, origins, targets - origins) == (0, 0)


def test_rays_in_coordinate_planes_do_not_escape_a_symmetric_mesh():
    """Vertices, edges and sides of boxes lie in the planes x = 0, y = 0 and z = 0, and so do the rays."""
    mesh, random = closed_meshes.icosphere(4), np.random.default_rng(8)
    rays = closed_meshes.rays_in_coordinate_planes(random, 100_000)
    assert escaped(placed(mesh, linalg.identity()), *rays) == (0, 0)
