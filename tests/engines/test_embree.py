"""Hits against Embree, which works in float32 too: where the two differ, float64 says who is right."""

import numpy as np
import pytest

import closed_meshes
import oracle
import tracing
from glimt import linalg, load
from glimt.layout import MISS
from glimt.packed import pack
from glimt.scene.camera import Camera
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene

rtcore_scene = pytest.importorskip("embreex.rtcore_scene", reason="embreex is not installed here")
mesh_construction = pytest.importorskip("embreex.mesh_construction")

MOST_WRONG = 4
"""Of a million rays, how many may hit the wrong one of two triangles that meet in an edge closer than float32 can tell.
Measured: 0 to 3, out of 1 to 9 that differ; in the others it is Embree that has the wrong one."""


@pytest.fixture(scope="module", params=["bunny", "made here"])
def mesh(request):
    if request.param == "made here":
        return closed_meshes.icosphere(6, roughness=0.02)
    return load(request.getfixturevalue("real_scenes") / "stanford_bunny" / "stanford-bunny.obj").objects[0].mesh


def camera_rays(mesh):
    """Return a million coherent rays: (3,) origin, (n, 3) directions."""
    camera = Camera.framing(*mesh.bounds())
    right, up, look = camera.basis()
    y, x = np.mgrid[0.38:-0.38:1000j, -0.38:0.38:1000j]
    directions = linalg.normalize(look + x[..., None] * right + y[..., None] * up)
    return np.float32(camera.position), directions.reshape(-1, 3).astype(np.float32)


def random_rays(mesh):
    """Return a million rays from in and around the mesh to points within its bounds."""
    random, (lo, hi) = np.random.default_rng(0), mesh.bounds()
    origins = random.uniform(lo - 0.3 * (hi - lo), hi + 0.3 * (hi - lo), (1_000_000, 3)).astype(np.float32)
    return origins, (random.uniform(lo, hi, origins.shape) - origins).astype(np.float32)


@pytest.mark.parametrize("rays", [camera_rays, random_rays])
@pytest.mark.parametrize("robust", [False, True])
def test_hits_are_those_of_embree(mesh, rays, robust):
    origins, directions = rays(mesh)
    ours, theirs = tracing.closest(pack(Scene().add(mesh)), origins, directions), np.recarray(1_000_000, tracing.HIT)
    origins = np.ascontiguousarray(np.broadcast_to(origins, directions.shape))
    scene = rtcore_scene.EmbreeScene(robust=robust)
    mesh_construction.TriangleMesh(scene, mesh.positions, mesh.triangles)
    found = scene.run(origins, directions, query="INTERSECT", output=True)
    theirs.t, theirs.u, theirs.v, theirs.prim = found["tfar"], found["u"], found["v"], found["primID"]
    theirs.inst = np.where(theirs.prim == MISS, MISS, 0)
    theirs.u, theirs.v = np.maximum(theirs.u, 0), np.maximum(theirs.v, 0)  # on an edge Embree goes below 0

    same = ours.prim == theirs.prim
    hit = same & (ours.prim != MISS)
    assert hit.mean() > 0.15
    np.testing.assert_allclose(ours.t[hit], theirs.t[hit], rtol=1e-3)
    wrong = 0
    for ray in np.flatnonzero(~same):
        exact, excused = judge(mesh, origins[ray], directions[ray], ours[ray], theirs[ray])
        assert excused, (origins[ray], directions[ray], ours[ray], theirs[ray])
        wrong += exact != ours.prim[ray]
    assert wrong <= MOST_WRONG, f"{(~same).sum()} rays differ, in {wrong} of them Embree is right"


@pytest.mark.parametrize("rays", [camera_rays, random_rays])
def test_two_in_a_million_agree_with_neither_embree(mesh, rays):
    """Embree's two triangle tests disagree with each other on 3 to 10 rays of a million, all of them on edges."""
    origins, directions = rays(mesh)
    ours = tracing.closest(pack(Scene().add(mesh)), origins, directions)
    origins = np.ascontiguousarray(np.broadcast_to(origins, directions.shape))
    agreed = np.zeros(len(directions), bool)
    for robust in (False, True):
        scene = rtcore_scene.EmbreeScene(robust=robust)
        mesh_construction.TriangleMesh(scene, mesh.positions, mesh.triangles)
        agreed |= ours.prim == scene.run(origins, directions, query="INTERSECT", output=True)["primID"]
    assert (~agreed).sum() <= 2


def judge(mesh, origin, direction, ours, theirs):
    """Return (the triangle that is hit in exact arithmetic, whether rounding excuses both answers)."""
    around = np.unique(mesh.triangles[[hit.prim for hit in (ours, theirs) if hit.prim != MISS]])
    nearby = np.flatnonzero(np.isin(mesh.triangles, around).any(1))
    scene, numbers = Scene().add(Mesh(mesh.positions, mesh.triangles[nearby])), {MISS: MISS}
    numbers.update(zip(nearby.tolist(), range(len(nearby)), strict=True))
    ray = origin[None], direction[None]
    exact = oracle.closest(oracle.meetings(scene, *ray, tolerance=1e-13))[2][0]
    found = oracle.meetings(scene, *ray)
    excused = True
    for hit in (ours, theirs):
        renamed = np.recarray(1, tracing.HIT)
        renamed[0] = (hit.t, hit.u, hit.v, numbers[int(hit.prim)], hit.inst)
        excused &= not oracle.wrong_hits(found, renamed)[0]
    return nearby[exact] if exact != MISS else MISS, excused
