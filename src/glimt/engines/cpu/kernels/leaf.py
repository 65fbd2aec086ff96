"""Rays of a block at a leaf of a mesh's tree.

Where a packet has many of them, each has one lane for all triangles. A few have four lanes each, one for each triangle.

By the same operations in the same order as in a packet: a ray's hit is the same to the bit.
"""

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, RAY, first_packet, lanes_of_packet, without_packet
from glimt.engines.cpu.kernels.hit import block, hit_at, store_hit
from glimt.engines.cpu.kernels.packet import ANY_AXIS, Shears, other_axes, permute, shears_at
from glimt.engines.cpu.kernels.ray import keep
from glimt.engines.cpu.kernels.triangle import AXIS, CORNER, edges, meeting, sheared, triangle_leaf, within
from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    bits,
    count_trailing_zeros,
    from_bits,
    load,
    load4_repeated,
    load_int,
    numbers_in_fours,
    population_count,
    scalar,
    scalar_int,
    shuffle,
    stack_floats,
    stack_ints,
    store,
    vector3,
)
from glimt.layout import BOX_SLACK, LEAF_STEP, TRIANGLE_BLOCK

_AT_ONCE = LANES // 4
"""Rays that are tested at once."""

_FIRST_TRIANGLES = np.int32(0x1111)
"""The first triangle's lane of each ray."""
_FOUND = 3 * LANES


@inline
def _are_few(lanes, code, shared_origin):
    """Return whether some lanes of a packet are tested sooner by four triangles than all of it by one at a time.

    Closest hits have to be written down ray by ray, and camera rays nearly all have one.
    """
    return population_count(lanes) <= _AT_ONCE * (code % LEAF_STEP - (3 if shared_origin else 1))


@inline
def _each_in_four(v, index):
    return vector3(shuffle(v.x, index), shuffle(v.y, index), shuffle(v.z, index))


@inline
def _corner(words, at, shears):
    """Return the same corner of four triangles as `triangle._corner` does."""
    if shears.axis == ANY_AXIS:
        turned = permute(shears.longest_x, shears.longest_y,
                         vector3(load4_repeated(words, at), load4_repeated(words, at + AXIS),
                                 load4_repeated(words, at + 2 * AXIS)))
    else:
        x, y = other_axes(shears.axis)
        turned = vector3(load4_repeated(words, at + x * AXIS), load4_repeated(words, at + y * AXIS),
                         load4_repeated(words, at + shears.axis * AXIS))
    return sheared(turned, shears)


@inline
def _rays_of(inside, lanes):
    """Return those of the first of some lanes that are inside of any of their four triangles."""
    inside |= inside >> 2
    inside |= inside >> 1
    rays = np.int32(0)
    for k in range(_AT_ONCE):
        rays |= lanes & -lanes & -(inside >> 4 * k & 1)
        lanes &= lanes - 1
    return rays


@inline
def _leaf_of_few(scene, inst, code, rays, hits, slot, lanes, occlusion):
    """Test the triangles of a leaf block for some lanes of a packet (see `triangle.triangle_leaf`)."""
    words, base = scene.blas_blocks, np.int64(code // LEAF_STEP) * TRIANGLE_BLOCK.words
    count = np.int32(code % LEAF_STEP)
    triangles = _FIRST_TRIANGLES * ((np.int32(1) << count) - np.int32(1))
    packet, blocked = shears_at(rays, slot), np.int32(0)
    found, slots = stack_floats(_FOUND), stack_ints(LANES)
    while lanes:
        index, inside, here = numbers_in_fours(lanes), triangles, lanes
        if population_count(lanes) < _AT_ONCE:
            inside &= (np.int32(1) << 4 * population_count(lanes)) - np.int32(1)
        for _ in range(_AT_ONCE):
            lanes &= lanes - 1
        longest = shuffle(load_int(rays, RAY.longest + slot), index)
        shears = Shears(packet.axis, longest == 0, longest == 1,
                        _each_in_four(packet.shear, index), _each_in_four(packet.shear_origin, index))
        limit = shuffle(load(hits, HIT.t + slot), index)
        a, b = _corner(words, base, shears), _corner(words, base + CORNER, shears)
        c = _corner(words, base + 2 * CORNER, shears)
        wa, wb, wc, between = edges(a, b, c)
        inside &= bits(between)
        if inside:
            t, u, v = meeting(wa, wb, wc, a.z, b.z, c.z, shears.shear.z)
            inside &= bits(within(a, b, c) & (t > 0.0))
            if occlusion:
                blocked |= _rays_of(inside & bits(t < limit), here)
                continue
            inside &= bits(t <= limit)
            store(slots, 0, index)
            store(found, 0, t)
            store(found, LANES, u)
            store(found, 2 * LANES, v)
            while inside:
                j = np.int64(count_trailing_zeros(inside))
                inside &= inside - 1
                keep(scene, base, inst, hits, slot + scalar_int(slots, j), j & 3, scalar(found, j),
                     scalar(found, LANES + j), scalar(found, 2 * LANES + j))
    if blocked:
        store_hit(hits, slot, block(hit_at(hits, slot), from_bits(blocked), np.int32(code), inst))


@inline
def meet_leaf(scene, inst, code, bundle, lanes, distance):
    """Test the triangles of a leaf of a mesh's tree for those of some rays that still look as far as `distance`."""
    while lanes:
        slot = first_packet(lanes)
        here = lanes_of_packet(lanes, slot) & bits(load(bundle.hits, HIT.t + slot) * BOX_SLACK >= distance)
        lanes = without_packet(lanes, slot)
        if _are_few(here, code, bundle.shared_origin):
            _leaf_of_few(scene, inst, code, bundle.rays, bundle.hits, slot, here, bundle.occlusion)
        else:
            hit = triangle_leaf(scene, inst, code, shears_at(bundle.rays, slot), hit_at(bundle.hits, slot),
                                bundle.occlusion)
            store_hit(bundle.hits, slot, hit)
