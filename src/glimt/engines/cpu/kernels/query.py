"""Entry points that answer rays from arrays instead of making them from pixels."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.traverse import closest_hit, occluded
from glimt.kernel import inline, kernel
from glimt.lanes import LANES, atomic_add, i32, load, mask, select, store, vector3

CHUNK = 4096
"""Rays that a thread takes at once; a multiple of every lane width."""


@inline
def _ray(rays, n, i):
    """Return (origin, direction) of the packet that starts at ray i."""
    return (vector3(load(rays, i), load(rays, n + i), load(rays, 2 * n + i)),
            vector3(load(rays, 3 * n + i), load(rays, 4 * n + i), load(rays, 5 * n + i)))


@kernel
def find_hits(scene, rays, floats, ids, chunk, view, counters):
    """Answer (6, n) rays, n a multiple of 16, by (3, n) floats t, u, v and (2, n) ids prim, inst (MISS: none).

    `chunk` is one int64 that all threads share: the next chunk to take.
    """
    here = arrays(scene, 0, view, counters)
    n = rays.shape[1]
    while True:
        first = atomic_add(chunk, 0, 1) * CHUNK
        if first >= n:
            return
        for i in range(first, min(first + CHUNK, n), LANES):
            origin, direction = _ray(rays, n, i)
            hit = closest_hit(here, origin, direction, mask(True), np.bool_(False))
            store(floats, i, hit.t)
            store(floats, n + i, hit.u)
            store(floats, 2 * n + i, hit.v)
            store(ids, i, hit.prim)
            store(ids, n + i, hit.inst)


@kernel
def find_blocked(scene, rays, blocked, chunk, view, counters):
    """Write 1 to (n,) int32 `blocked` for each of (6, n) rays that meets something before t = 1, else 0."""
    here = arrays(scene, 0, view, counters)
    n = rays.shape[1]
    while True:
        first = atomic_add(chunk, 0, 1) * CHUNK
        if first >= n:
            return
        for i in range(first, min(first + CHUNK, n), LANES):
            origin, direction = _ray(rays, n, i)
            met = occluded(here, origin, direction, np.float32(1), mask(True))
            store(blocked, i, select(met, i32(1), 0))
