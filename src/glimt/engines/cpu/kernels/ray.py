"""One ray of a block, met by eight boxes or by four triangles at once.

By the same operations in the same order as in a packet: a ray's hit is the same to the bit.
"""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, RAY, SINGLE, SLOTS
from glimt.engines.cpu.kernels.hit import DONE, number_of
from glimt.engines.cpu.kernels.triangle import AXIS, CORNER, edges, meeting, within
from glimt.kernel import inline
from glimt.lanes import (
    bits,
    count_trailing_zeros,
    fma,
    i32,
    load,
    load4,
    load8,
    load_int,
    maximum,
    minimum,
    scalar,
    scalar_int,
    select,
    store,
    store_scalar,
    store_scalar_int,
)
from glimt.layout import BOTH_X, BOTH_Y, BOTH_Z, BOX_SLACK, LEAF_SIZE, LEAF_STEP, NODE, TRIANGLE_BLOCK

_Y, _Z = np.int64(SLOTS), np.int64(2 * SLOTS)  # words from a vector's x to its y and z
_PLANES = _Y // AXIS
"""Words from one axis to the next among rays for each of those in a leaf block."""

_U, _V = np.int64(LEAF_SIZE), np.int64(2 * LEAF_SIZE)  # words from the t at which triangles are met to u and v
MET_WORDS = 3 * int(LEAF_SIZE)
"""Words of where a ray meets the triangles of a leaf."""


class Corner(NamedTuple):
    """The same corner of four triangles as a ray sees it."""

    x: object
    y: object
    z: object


@inline
def put_single(rays, singles, slot):
    """Write what single rays need besides the planes of their packet."""
    order = i32(NODE.order)
    lo = (i32(NODE.lo_x), i32(NODE.lo_y), i32(NODE.lo_z))
    hi = (i32(NODE.hi_x), i32(NODE.hi_y), i32(NODE.hi_z))
    for k in range(3):
        inverse = load(rays, RAY.inverse + k * SLOTS + slot)
        store(singles, SINGLE.near + k * SLOTS + slot, select(inverse >= 0.0, lo[k], hi[k]))
        order = order + select(inverse >= 0.0, i32(0), i32(1 << k))
    store(singles, SINGLE.order + slot, order)
    longest = load_int(rays, RAY.longest + slot)
    x, y, z = i32(0), i32(AXIS), i32(2 * AXIS)
    longest_x, longest_y = longest == 0, longest == 1
    store(singles, SINGLE.axis + slot, select(longest_x, y, select(longest_y, z, x)))
    store(singles, SINGLE.axis + _Y + slot, select(longest_x, z, select(longest_y, x, y)))
    store(singles, SINGLE.axis + _Z + slot, select(longest_x, x, select(longest_y, y, z)))


@inline
def children(nodes, base, rays, singles, hits, slot):
    """Return (entry, exit) of a ray for the eight children of a node."""
    near = SINGLE.near + slot
    near_x, near_y = np.int64(scalar_int(singles, near)), np.int64(scalar_int(singles, near + _Y))
    near_z = np.int64(scalar_int(singles, near + _Z))
    inverse, near_add, far_add = RAY.inverse + slot, RAY.near_add + slot, RAY.far_add + slot
    x, y, z = scalar(rays, inverse), scalar(rays, inverse + _Y), scalar(rays, inverse + _Z)
    entry = maximum(maximum(fma(load8(nodes, base + near_x), x, scalar(rays, near_add)),
                            fma(load8(nodes, base + near_y), y, scalar(rays, near_add + _Y))),
                    maximum(fma(load8(nodes, base + near_z), z, scalar(rays, near_add + _Z)),
                            scalar(hits, HIT.begin + slot)))
    leave = minimum(minimum(fma(load8(nodes, base + BOTH_X - near_x), x, scalar(rays, far_add)),
                            fma(load8(nodes, base + BOTH_Y - near_y), y, scalar(rays, far_add + _Y))),
                    minimum(fma(load8(nodes, base + BOTH_Z - near_z), z, scalar(rays, far_add + _Z)),
                            scalar(hits, HIT.t + slot)))
    return entry, leave * BOX_SLACK


@inline
def _corners(words, at, rays, singles, slot):
    """Return (x, y, z) of the same corner of four triangles as `triangle._corner` does."""
    axis, origin, shear = SINGLE.axis + slot, RAY.origin + slot, RAY.shear + slot
    axis_x, axis_y = np.int64(scalar_int(singles, axis)), np.int64(scalar_int(singles, axis + _Y))
    axis_z = np.int64(scalar_int(singles, axis + _Z))
    z = load4(words, at + axis_z) - scalar(rays, origin + axis_z * _PLANES)
    return Corner(fma(-scalar(rays, shear), z, load4(words, at + axis_x) - scalar(rays, origin + axis_x * _PLANES)),
                  fma(-scalar(rays, shear + _Y), z,
                      load4(words, at + axis_y) - scalar(rays, origin + axis_y * _PLANES)), z)


@inline
def keep(scene, base, inst, hits, slot, j, t, u, v):
    """Make triangle j of the block at `base`, at t > 0, a ray's hit if it is closer (see `hit.closer`)."""
    limit, prim = scalar(hits, HIT.t + slot), scalar_int(scene.blas_blocks, base + TRIANGLE_BLOCK.prim + j)
    if t == limit:
        before = scalar_int(hits, HIT.inst + slot)
        rival = scalar_int(hits, HIT.prim + slot)
        if before < inst or (before == inst
                             and number_of(scene, inst, rival, True) <= number_of(scene, inst, prim, True)):
            return
    if t <= limit:
        store_scalar(hits, HIT.t + slot, t)
        store_scalar(hits, HIT.u + slot, u)
        store_scalar(hits, HIT.v + slot, v)
        store_scalar_int(hits, HIT.prim + slot, prim)
        store_scalar_int(hits, HIT.inst + slot, inst)


@inline
def leaf(scene, code, rays, singles, hits, slot, met, place, occlusion):
    """Test up to four triangles at once (see `triangle.triangle_leaf`); return those met before the ray's hit as bits.

    Where they are met is written to `met` from `place` on. There is no branch: see `take_hits`.
    """
    words, base = scene.blas_blocks, np.int64(code // LEAF_STEP) * TRIANGLE_BLOCK.words
    a = _corners(words, base, rays, singles, slot)
    b = _corners(words, base + CORNER, rays, singles, slot)
    c = _corners(words, base + 2 * CORNER, rays, singles, slot)
    wa, wb, wc, between = edges(a, b, c)
    longest = np.int64(scalar_int(singles, SINGLE.axis + _Z + slot)) * _PLANES
    t, u, v = meeting(wa, wb, wc, a.z, b.z, c.z, scalar(rays, RAY.inverse + longest + slot))
    store(met, place, t)
    store(met, place + _U, u)
    store(met, place + _V, v)
    limit = scalar(hits, HIT.t + slot)
    inside = between & within(a, b, c) & (t > 0.0) & (t < limit if occlusion else t <= limit)
    return np.int32(bits(inside) & ((1 << (code % LEAF_STEP)) - 1))


@inline
def take_hits(scene, inst, code, hits, slot, met, place, inside, occlusion):
    """Make the nearest of the triangles that a ray has met at a `leaf` its hit; with `occlusion` it is done."""
    if occlusion:
        if inside:
            store_scalar(hits, HIT.t + slot, DONE)
            store_scalar_int(hits, HIT.prim + slot, code)
            store_scalar_int(hits, HIT.inst + slot, inst)
        return
    base = np.int64(code // LEAF_STEP) * TRIANGLE_BLOCK.words
    while inside:
        j = np.int64(count_trailing_zeros(inside))
        inside &= inside - 1
        keep(scene, base, inst, hits, slot, j, scalar(met, place + j), scalar(met, place + _U + j),
             scalar(met, place + _V + j))
