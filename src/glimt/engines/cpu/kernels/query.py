"""Entry points that answer rays from arrays instead of making them from pixels."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import trees
from glimt.engines.cpu.kernels.block import HIT, HIT_WORDS, RAY_WORDS, SLOTS
from glimt.engines.cpu.kernels.clearance import clear_distance
from glimt.engines.cpu.kernels.hit import begin_hits, hit_at
from glimt.engines.cpu.kernels.packet import fill_idle, set_up
from glimt.engines.cpu.kernels.traverse import NO_FLAGS, OCCLUSION, SHARED_ORIGIN, TRACE, trace
from glimt.kernel import calls, inline, kernel
from glimt.lanes import (
    LANES,
    any_lane,
    atomic_add,
    f32,
    i32,
    load,
    load_int,
    maximum,
    scalar,
    select,
    stack_floats,
    store,
    vector3,
)
from glimt.layout import MISS

NO_SOURCES = np.zeros((5, 0), np.float32)
"""`sources` of rays that leave no mesh, or nothing that is known of."""

CHUNK = 4096
"""Rays that a thread takes at once; a multiple of every block's size."""


@inline
def _begin(rays, sources, shared_origin, n, i, block, hits):
    """Set up the block of rays that starts at ray i; return its packets with anything to do."""
    packets = np.int32(0)
    for k in range(min(SLOTS, n - i) // LANES):
        slot = np.int64(k * LANES)
        at = i + slot
        t_max = load(rays, 6 * n + at)
        active = t_max > 0.0
        clear, source = f32(0.0), i32(MISS)
        if sources.shape[1]:
            clear = clear_distance(load_int(sources, at), load(sources, n + at), load(sources, 2 * n + at))
            clear = maximum(clear - load(sources, 3 * n + at), 0.0)
            source = load_int(sources, 4 * n + at)
        begin_hits(hits, slot, active, t_max, clear, source)
        if any_lane(active):
            packets |= np.int32(1) << np.int32(k)
            if shared_origin:  # three planes of memory less to go through
                origin = vector3(f32(scalar(rays, 0)), f32(scalar(rays, n)), f32(scalar(rays, 2 * n)))
            else:
                origin = fill_idle(active, vector3(load(rays, at), load(rays, n + at), load(rays, 2 * n + at)))
            direction = vector3(load(rays, 3 * n + at), load(rays, 4 * n + at), load(rays, 5 * n + at))
            set_up(block, slot, origin, fill_idle(active, direction))
    return packets


@calls(TRACE)
@kernel
def find_hits(scene, rays, sources, shared_origin, floats, ids, chunk):
    """Answer rays by the nearest thing they meet.

    Parameters
    ----------
    scene : PackedScene
    rays : (7, n) float32
        Origins, directions, and how far each looks; one that looks no farther than 0 is idle. n is a multiple of 16.
    sources : (5, n) float32
        What is known of the surfaces that rays leave: FACE.clearance, a ray's t after one of their units, the sine
        at which it rises, how much nearer (in t) than the surface's points things may be to where it begins, the
        instance. The first and the last are int32. Or NO_SOURCES.
    shared_origin : bool
        Whether all start in one point: that of the first, whatever the others say.
    floats, ids : (3, n) float32, (2, n) int32
        Receive t, u, v and prim, inst (MISS: none); t of an idle ray is -inf.
    chunk : (1,) int64
        Shared by all threads: the next chunk to take.
    """
    here = trees(scene)
    block, local, hits = stack_floats(RAY_WORDS), stack_floats(RAY_WORDS), stack_floats(HIT_WORDS)
    flags = SHARED_ORIGIN if shared_origin else NO_FLAGS
    n = rays.shape[1]
    while True:
        first = atomic_add(chunk, 0, 1) * CHUNK
        if first >= n:
            return
        for i in range(first, min(first + CHUNK, n), SLOTS):
            trace(here, block, local, hits, flags, _begin(rays, sources, shared_origin, n, i, block, hits))
            for k in range(min(SLOTS, n - i) // LANES):
                at, hit = i + k * LANES, hit_at(hits, np.int64(k * LANES))
                store(floats, at, hit.t)
                store(floats, n + at, hit.u)
                store(floats, 2 * n + at, hit.v)
                store(ids, at, hit.prim)
                store(ids, n + at, hit.inst)


@calls(TRACE)
@kernel
def find_blocked(scene, rays, sources, shared_origin, blocked, chunk):
    """Write 1 to (n,) float32 `blocked` for each ray that meets something, else 0; the rest as for `find_hits`."""
    here = trees(scene)
    block, local, hits = stack_floats(RAY_WORDS), stack_floats(RAY_WORDS), stack_floats(HIT_WORDS)
    flags = SHARED_ORIGIN | OCCLUSION if shared_origin else OCCLUSION
    n = rays.shape[1]
    while True:
        first = atomic_add(chunk, 0, 1) * CHUNK
        if first >= n:
            return
        for i in range(first, min(first + CHUNK, n), SLOTS):
            trace(here, block, local, hits, flags, _begin(rays, sources, shared_origin, n, i, block, hits))
            for k in range(min(SLOTS, n - i) // LANES):
                at = i + k * LANES
                met = (load(rays, 6 * n + at) > 0.0) & (load(hits, HIT.t + np.int64(k * LANES)) < 0.0)
                store(blocked, at, select(met, f32(1.0), 0.0))
