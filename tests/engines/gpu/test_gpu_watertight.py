"""No ray leaves a closed mesh unseen on the GPU either: not between triangles, not at a corner, not far away."""

import numpy as np
import pytest
from kernel_calls import on_invocations

import closed_meshes
from closed_meshes import MATRICES, inner_points
from glimt import linalg
from glimt.scene.instance import Instance
from glimt.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("software_gpu")

BODY = """
    var counts = Counts(0u, 0u, 0u);
    let hit = closest_hit(vector(0u), vector(3u), FAR, &counts);
    put_flag(0u, hit.inst != MISS);
    put_flag(1u, occluded(vector(0u), vector(3u), FAR, &counts));
"""


@pytest.fixture(scope="module", params=closed_meshes.UNEVEN)
def mesh(request):
    """Thousands of triangles without any symmetry left."""
    return closed_meshes.UNEVEN[request.param]()


def escaped(scene, origins, directions):
    """Return how many rays meet nothing, by either way of asking."""
    count = -(-len(directions) // 64) * 64
    rays = np.concatenate([np.broadcast_to(origins, directions.shape), directions], 1).astype(np.float32)
    met = on_invocations(scene, BODY, np.resize(rays, (count, 6)).T.copy(), 2)
    return tuple((met == 0).sum(1).tolist())


@pytest.mark.parametrize("place", MATRICES)
def test_random_rays_do_not_escape(mesh, place):
    matrix, random = MATRICES[place], np.random.default_rng(5)
    origins = linalg.transform_points(matrix, inner_points(mesh, random, 200_000))
    assert escaped(Scene().add(Instance(mesh, matrix)), origins, random.standard_normal((200_000, 3))) == (0, 0)


@pytest.mark.parametrize("place", MATRICES)
def test_rays_at_vertices_and_edges_do_not_escape(mesh, place):
    """At each vertex and at the middle of each edge, as exactly as float32 can aim."""
    matrix, random = MATRICES[place], np.random.default_rng(6)
    middles = mesh.positions[closed_meshes.edges(mesh)].mean(1, dtype=np.float64)
    targets = np.tile(np.concatenate([mesh.positions, middles]), (8, 1))
    for origin in (linalg.transform_points(matrix, inner_points(mesh, random, len(targets))),
                   linalg.transform_points(matrix, inner_points(mesh, random, 1)[0])):  # apart, and from one point
        origin = origin.astype(np.float32)
        directions = linalg.transform_points(matrix, targets) - origin
        assert escaped(Scene().add(Instance(mesh, matrix)), origin, directions) == (0, 0)


@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1.0, 1e5, 1e12])
def test_size_does_not_matter(scale):
    mesh, random = closed_meshes.icosphere(3, roughness=0.04), np.random.default_rng(7)
    origins = inner_points(mesh, random, 50_000) * scale
    targets = mesh.positions[random.integers(len(mesh.positions), size=50_000)] * scale
    for scene in (Scene().add(Instance(mesh, linalg.scaling(scale))),
                  Scene().add(type(mesh)(mesh.positions * np.float64(scale), mesh.triangles))):
        assert escaped(scene, origins, targets - origins) == (0, 0)


def test_rays_in_coordinate_planes_do_not_escape_a_symmetric_mesh():
    """Vertices, edges and sides of boxes lie in the planes x = 0, y = 0 and z = 0, and so do the rays."""
    mesh, random = closed_meshes.icosphere(4), np.random.default_rng(8)
    assert escaped(Scene().add(mesh), *closed_meshes.rays_in_coordinate_planes(random, 100_000)) == (0, 0)
