"""Rays a second by kind, against Embree's best on the same rays in the same run."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
from glimt.bench.embree import EmbreeScene
from glimt.bench.embree_rays import Configuration, Tracers
from glimt.bench.measure import Tell, interleave, machine, median, over_threads
from glimt.bench.results import AT_ONCE
from glimt.engines.cpu.closest_hits import closest_hits
from glimt.engines.cpu.kernels.query import NO_SOURCES, find_blocked, find_hits
from glimt.layout import FACE, INSTANCE, aligned, aligned_copy, dtype
from glimt.packed import PackedScene, Packer
from glimt.scene.camera import Camera
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene

Rays = NDArray[np.float32]
_GRANULE = 16  # ray sets are cut to whole packets of every width


class RaySet(NamedTuple):
    """Rays of one kind: (7, n) origins, directions and how far they look; whether only being blocked is asked.

    shared_origin: whether all start in one point; sources: see `find_hits`.
    """

    kind: str
    rays: Rays
    occlusion: bool
    shared_origin: bool
    sources: Rays = NO_SOURCES


def ray_sets(mesh: Mesh, packed: PackedScene, size: int) -> list[RaySet]:
    """Return the rays of all kinds for one mesh.

    Primary rays of a size×size picture, the shadow and mirror rays of what they hit, which know what they leave, and as
    many rays as primary ones between random points of the mesh's box.
    """
    lo, hi = (bound.astype(np.float64) for bound in mesh.bounds())
    camera = Camera.framing(lo, hi)
    primary = _primary(camera, size)
    floats, ids = closest_hits(packed, primary)
    found = ids[1] >= 0
    corners = mesh.positions[mesh.triangles[ids[0][found]]].astype(np.float64)
    u, v = floats[1][found, None], floats[2][found, None]
    direction = primary[3:6].T[found].astype(np.float64)
    normal = linalg.normalize(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    turned = -np.sign((normal * direction).sum(1))
    normal *= turned[:, None]
    reach = np.linalg.norm(hi - lo)
    offset = float(1e-5 * reach)
    point = corners[:, 0] * (1 - u - v) + corners[:, 1] * u + corners[:, 2] * v + normal * offset
    light = np.asarray(camera.position) + reach * (0.5 * camera.basis().up - 0.7 * camera.basis().right)
    mirrored = direction - 2 * normal * (normal * direction).sum(1, keepdims=True)
    random = np.random.default_rng(1)
    ends = random.uniform(lo - 0.1 * (hi - lo), hi + 0.1 * (hi - lo), (2, primary.shape[1], 3))
    leave = partial(_sources, packed, ids[0][found], turned, normal, offset)
    return [RaySet("primary", primary, False, True),
            RaySet("shadow", _join(point, light - point, 1.0), True, False, leave(light - point)),
            RaySet("mirror", _join(point, mirrored), False, False, leave(mirrored)),
            RaySet("incoherent", _join(ends[0], linalg.normalize(ends[1] - ends[0])), False, False)]


def _join(origins: NDArray[Any], directions: NDArray[Any], t_max: float = np.inf) -> Rays:
    count = len(origins) // _GRANULE * _GRANULE
    rays = np.full((7, count), t_max, np.float32)
    rays[:3], rays[3:6] = origins[:count].T, directions[:count].T
    return aligned_copy(rays)


def _sources(packed: PackedScene, prims: NDArray[np.int32], turned: NDArray[Any], normals: NDArray[Any],
             offset: float, directions: NDArray[Any]) -> Rays:
    """Return what the frame kernel knows of rays that leave triangles of the only instance, `offset` above them.

    turned: 1 where a normal is on the counter-clockwise side, else -1.
    """
    unit = float(packed.instances.view(dtype(INSTANCE))["clear_unit"][0])
    lengths = np.linalg.norm(directions, axis=1)
    count = len(prims) // _GRANULE * _GRANULE
    sources = np.zeros((5, count), np.float32)
    faces = packed.faces.view(dtype(FACE))
    clearances = faces["clearance"][np.argsort(faces["number"])]
    sources[0] = np.where(turned * unit > 0, clearances[prims], 0).astype(np.int32).view(np.float32)[:count]
    sources[1] = (abs(unit) / lengths)[:count]
    sources[2] = ((normals * directions).sum(1) / lengths)[:count]
    sources[3] = (2 * offset / lengths)[:count]
    return aligned_copy(sources)


def _primary(camera: Camera, size: int) -> Rays:
    """Return the camera's rays in packets of 4×4 pixels within blocks of 8×8 within tiles of 16×16, as the engine."""
    index = np.arange(size * size).reshape(size // 16, size // 16, 2, 2, 2, 2, 4, 4)
    tile_y, tile_x, block_y, block_x, packet_y, packet_x, y, x = np.unravel_index(index.ravel(), index.shape)
    column, row = tile_x * 16 + block_x * 8 + packet_x * 4 + x, tile_y * 16 + block_y * 8 + packet_y * 4 + y
    basis, reach = camera.basis(), np.tan(np.radians(camera.fov_deg) / 2)
    right, up = (2 * column + 1) / size - 1, 1 - (2 * row + 1) / size
    directions = basis.look + reach * (right[:, None] * basis.right + up[:, None] * basis.up)
    return _join(np.broadcast_to(camera.position, directions.shape), linalg.normalize(directions))


def measure_mesh(mesh: Mesh, size: int = 1024, threads: tuple[int, ...] = (1,), rounds: int = 5,
                 tell: Tell = lambda text: None) -> list[dict[str, Any]]:
    """Return a row for each kind of ray and number of threads.

    A row holds Mrays/s of glimt and of every Embree configuration (medians), the best of those, `ratio`, which is
    glimt's rate through the best one's, and `differing`, rays per million whose answer differs from Embree's. For rays
    that leave the mesh it also holds glimt's rate where nothing is known of clearances.
    """
    scene = Scene().add(mesh)
    packer, embree = Packer(threads=max(threads)), Tracers(EmbreeScene(scene))
    packed = packer.pack(scene)
    packer.clearances().finish()
    rows = []
    with ThreadPoolExecutor(max(threads)) as pool:
        for ray_set in ray_sets(mesh, packed, size // 16 * 16):
            for count in threads:
                tell(f"{mesh.name}: {ray_set.kind}, threads: {count}")
                rows.append(_measure_set(mesh, packed, embree, ray_set, pool, count, rounds))
    return rows


def _measure_set(mesh: Mesh, packed: PackedScene, embree: Tracers, ray_set: RaySet, pool: ThreadPoolExecutor,
                 threads: int, rounds: int) -> dict[str, Any]:
    rays, n = ray_set.rays, ray_set.rays.shape[1]
    floats, ids, blocked = aligned(3 * n).reshape(3, n), aligned(2 * n, np.int32).reshape(2, n), aligned(n)
    t, prims = aligned(n), aligned(n, np.int32)

    def ours(sources: Rays, chunk: NDArray[np.int64]) -> None:
        if ray_set.occlusion:
            find_blocked(packed, rays, sources, ray_set.shared_origin, blocked, chunk)
        else:
            find_hits(packed, rays, sources, ray_set.shared_origin, floats, ids, chunk)

    def theirs(how: Configuration) -> Callable[[], None]:
        trace = embree.get(how, ray_set.occlusion, ray_set.shared_origin)
        return lambda: over_threads(pool, threads, lambda chunk: trace(ray_set.rays, t, prims, chunk))

    ways = embree.configurations
    runs = {str(how): theirs(how) for how in ways}
    if ray_set.sources.size:
        runs[AT_ONCE] = lambda: over_threads(pool, threads, partial(ours, NO_SOURCES))
    runs["glimt"] = lambda: over_threads(pool, threads, partial(ours, ray_set.sources))
    rates = {name: n / median(seconds) / 1e6 for name, seconds in interleave(runs, rounds).items()}
    runs[str(ways[-1])]()
    wrong = (blocked > 0) != (t < 0) if ray_set.occlusion else packed.numbers_in_mesh(*ids) != prims
    best = max((str(how) for how in ways), key=lambda name: rates[name])
    return {"mesh": mesh.name, "triangles": len(mesh.triangles), "kind": ray_set.kind, "threads": threads, "rays": n,
            "mrays": rates, "best": best, "ratio": rates["glimt"] / rates[best],
            "differing": 1e6 * float(wrong.mean())}


def report(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a result to be written as JSON."""
    return {"benchmark": "rays", "version": 1, "machine": machine(), "rows": rows}
