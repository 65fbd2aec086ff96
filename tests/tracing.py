"""Rays through the CPU engine's traversal: packed as lanes, answered as arrays."""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.traverse import closest_hit, occluded
from glimt.kernel import kernel
from glimt.lanes import LANES, any_lane, f32, load, select, store, vector3
from glimt.layout import MISS

HIT = np.dtype([("t", "f4"), ("u", "f4"), ("v", "f4"), ("prim", "i4"), ("inst", "i4")])
"""A ray's answer; inst and prim are MISS where it meets nothing (t is inf) or was not asked (t is -inf)."""

THREADS = os.cpu_count() or 1
_CHUNK = 1 << 16  # rays that a thread takes at once
_NO_VIEW, _NO_COUNTERS = np.zeros(64, np.float32), np.zeros(16, np.int64)


@kernel
def trace_closest(scene, rays, active, shared_origin, floats, ids, view, counters):
    """Answer (6, n) rays, n a multiple of LANES, by (3, n) floats t, u, v and (2, n) ids prim, inst."""
    here = arrays(scene, 0, view, counters)
    n = rays.shape[1]
    for i in range(0, n, LANES):
        lanes = load(active, i) > 0.0
        if any_lane(lanes):
            origin = vector3(load(rays, i), load(rays, n + i), load(rays, 2 * n + i))
            direction = vector3(load(rays, 3 * n + i), load(rays, 4 * n + i), load(rays, 5 * n + i))
            hit = closest_hit(here, origin, direction, lanes, shared_origin)
            store(floats, i, hit.t)
            store(floats, n + i, hit.u)
            store(floats, 2 * n + i, hit.v)
            store(ids, i, hit.prim)
            store(ids, n + i, hit.inst)


@kernel
def trace_occluded(scene, rays, t_max, active, answers, view, counters):
    """Write 1 to (n,) answers for rays that meet something before t_max, n a multiple of LANES."""
    here = arrays(scene, 0, view, counters)
    n = rays.shape[1]
    for i in range(0, n, LANES):
        lanes = load(active, i) > 0.0
        if any_lane(lanes):
            origin = vector3(load(rays, i), load(rays, n + i), load(rays, 2 * n + i))
            direction = vector3(load(rays, 3 * n + i), load(rays, 4 * n + i), load(rays, 5 * n + i))
            met = occluded(here, origin, direction, t_max, lanes)
            store(answers, i, select(met, f32(1.0), 0.0))


def closest(packed, origins, directions, active=None):
    """Return the HIT of each ray as a record array.

    Parameters
    ----------
    packed : PackedScene
    origins : (n, 3) float32, or one (3,) for all, which then take the way of camera rays
    directions : (n, 3) float32
    active : (n,) bool, optional
        Rays to ask; the others are idle lanes among them.
    """
    hits = np.recarray(len(directions), HIT)

    def run(part, rays, lanes):
        floats, ids = np.zeros((3, len(lanes)), np.float32), np.full((2, len(lanes)), MISS, np.int32)
        floats[0] = -np.inf
        trace_closest(packed, rays, lanes, np.ndim(origins) == 1, floats, ids, _NO_VIEW, _NO_COUNTERS)
        for name, values in zip(HIT.names, [*floats, *ids], strict=True):
            hits[name][part] = values[:len(hits.t[part])]

    _over_threads(run, origins, directions, active)
    return hits


def blocked(packed, origins, directions, t_max=np.inf, active=None):
    """Return which rays meet something before `t_max`, (n,) bool; other arguments as for `closest`."""
    met = np.zeros(len(directions), bool)

    def run(part, rays, lanes):
        answers = np.zeros(len(lanes), np.float32)
        trace_occluded(packed, rays, np.float32(t_max), lanes, answers, _NO_VIEW, _NO_COUNTERS)
        met[part] = answers[:len(met[part])] > 0

    _over_threads(run, origins, directions, active)
    return met


def _over_threads(run, origins, directions, active):
    """Call run(slice, (6, n) rays, (n,) active) for chunks of the rays, each filled up with idle lanes."""
    count = len(directions)
    origins, directions = (np.broadcast_to(np.asarray(a, np.float32), (count, 3)) for a in (origins, directions))

    def take(first):
        part = slice(first, min(first + _CHUNK, count))
        size = part.stop - first
        rays = np.zeros((6, -(-size // LANES) * LANES), np.float32)
        lanes = np.zeros(rays.shape[1], np.float32)
        rays[:3, :size], rays[3:, :size] = origins[part].T, directions[part].T
        lanes[:size] = 1 if active is None else active[part]
        run(part, rays, lanes)

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(take, range(0, count, _CHUNK)))
