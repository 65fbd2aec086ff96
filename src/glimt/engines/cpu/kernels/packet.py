"""Packets of rays, set up for boxes and for triangles in one space.

For boxes: planes are reached at ``plane * inverse + add``, where `near_add` and `far_add` are ``-origin * inverse``
moved apart by more than the rounding error of the origin (of its largest coordinate, since matrices mix them), so that
a box is never missed (after Ize, "Robust BVH ray traversal", 2013, with an absolute bound instead of a factor). The
interval of one or more packets answers for eight boxes at once.

For triangles: the shear that turns the ray into the z axis (Woop, Benthin, Wald, "Watertight ray/triangle
intersection", 2013).
"""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.block import RAY, SLOTS
from glimt.engines.cpu.kernels.surface import largest
from glimt.kernel import inline, routine
from glimt.lanes import (
    LANES,
    absolute,
    all_lanes,
    any_lane,
    bits,
    count_trailing_zeros,
    extract,
    fma,
    highest,
    i32,
    load,
    load3,
    load_int,
    lowest,
    maximum,
    minimum,
    reciprocal,
    scalar_int,
    select,
    store,
    store3,
    store_scalar_int,
    vector3,
)
from glimt.layout import NODE

_SMALLEST = np.float32(2.0**-60)
"""The least component of a direction as a share of its greatest."""
_TINY = np.float32(1e-36)
_ROUNDING = np.float32(16 * 2.0**-24)
_HUGE = np.float32(3e38)
ANY_AXIS = np.int32(3)
"""`axis` of a packet whose rays have different longest axes."""


class Rays(NamedTuple):
    """A packet of rays in one space, in registers; `t` means the same in all spaces."""

    origin: object
    direction: object
    inverse: object
    near_add: object
    far_add: object


class Shears(NamedTuple):
    """What turns rays into the z axis.

    axis: the longest one of all, or ANY_AXIS; longest_x, longest_y: lanes where it is x or y; shear: by how much z
    moves x and y, and by what it is scaled; shear_origin: the origin, turned as well.
    """

    axis: object
    longest_x: object
    longest_y: object
    shear: object
    shear_origin: object


class Slab(NamedTuple):
    """One axis of an interval: the word offset of the plane its rays meet first, and the terms of both planes."""

    near_plane: object
    near_factor: object
    near_add: object
    far_factor: object
    far_add: object
    mixed: object


class Interval(NamedTuple):
    """What holds all rays of some packets.

    `mixed`: on some axis they differ in sign; `incoherent`: on every axis; `order`: offset of the order in which they
    meet a node's children.
    """

    slab_x: object
    slab_y: object
    slab_z: object
    mixed: object
    incoherent: object
    order: object


@inline
def _not_too_small(d, least):
    """Return d, or where it is next to nothing the least that can be divided by."""
    return select(absolute(d) < least, select(d < 0.0, -least, least), d)


@inline
def permute(longest_x, longest_y, v):
    """Return v with its components turned so that the longest axis is z."""
    return vector3(select(longest_x, v.y, select(longest_y, v.z, v.x)),
                   select(longest_x, v.z, select(longest_y, v.x, v.y)),
                   select(longest_x, v.x, select(longest_y, v.y, v.z)))


@inline
def other_axes(axis):
    """Return (axis + 1, axis + 2) modulo 3, without divisions."""
    return (0b00_10_01 >> 2 * axis) & 3, (0b01_00_10 >> 2 * axis) & 3


@inline
def _turned(words, at, axis, longest_x, longest_y):
    """Return the vectors of a packet with their components turned so that the longest axis of each ray is z."""
    if axis == ANY_AXIS:
        return permute(longest_x, longest_y, load3(words, at, SLOTS))
    x, y = other_axes(axis)
    return vector3(load(words, at + x * SLOTS), load(words, at + y * SLOTS), load(words, at + axis * SLOTS))


@inline
def set_up(words, slot, origin, direction):
    """Write the rays of a packet to its slots of a RAY block; every lane must hold a ray."""
    d = direction
    ax, ay, az = absolute(d.x), absolute(d.y), absolute(d.z)
    least = maximum(largest(d) * _SMALLEST, _TINY)
    if any_lane(minimum(ax, minimum(ay, az)) < least):
        d = vector3(_not_too_small(d.x, least), _not_too_small(d.y, least), _not_too_small(d.z, least))
    inverse = vector3(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z))
    error = largest(origin) * _ROUNDING
    pad = vector3(absolute(inverse.x) * error, absolute(inverse.y) * error, absolute(inverse.z) * error)
    store3(words, RAY.origin + slot, SLOTS, origin)
    store3(words, RAY.direction + slot, SLOTS, direction)
    store3(words, RAY.inverse + slot, SLOTS, inverse)
    store3(words, RAY.near_add + slot, SLOTS, vector3(
        fma(-origin.x, inverse.x, -pad.x), fma(-origin.y, inverse.y, -pad.y), fma(-origin.z, inverse.z, -pad.z)))
    store3(words, RAY.far_add + slot, SLOTS, vector3(
        fma(-origin.x, inverse.x, pad.x), fma(-origin.y, inverse.y, pad.y), fma(-origin.z, inverse.z, pad.z)))

    # Shear along the longest axis of each ray, always the same one for the same ray.
    longest_x = (ax > ay) & (ax > az)
    longest_y = (ay >= ax) & (ay > az)
    axis = ANY_AXIS
    if all_lanes(longest_x):
        axis = np.int32(0)
    elif all_lanes(longest_y):
        axis = np.int32(1)
    elif not any_lane(longest_x | longest_y):
        axis = np.int32(2)
    turned = _turned(words, RAY.direction + slot, axis, longest_x, longest_y)
    depth = _turned(words, RAY.inverse + slot, axis, longest_x, longest_y).z
    store(words, RAY.shear + slot, turned.x * depth)
    store(words, RAY.shear + SLOTS + slot, turned.y * depth)
    store(words, RAY.longest + slot, select(longest_x, i32(0), select(longest_y, i32(1), 2)))
    store_scalar_int(words, RAY.axis + slot, axis)


@inline
def rays_at(words, slot):
    """Return the rays of a packet; what is not used of them is not loaded."""
    return Rays(load3(words, RAY.origin + slot, SLOTS), load3(words, RAY.direction + slot, SLOTS),
                load3(words, RAY.inverse + slot, SLOTS), load3(words, RAY.near_add + slot, SLOTS),
                load3(words, RAY.far_add + slot, SLOTS))


@inline
def shears_at(words, slot):
    """Return the Shears of a packet."""
    axis, longest = scalar_int(words, RAY.axis + slot), load_int(words, RAY.longest + slot)
    longest_x, longest_y = longest == 0, longest == 1
    depth = _turned(words, RAY.inverse + slot, axis, longest_x, longest_y).z
    return Shears(axis, longest_x, longest_y,
                  vector3(load(words, RAY.shear + slot), load(words, RAY.shear + SLOTS + slot), depth),
                  _turned(words, RAY.origin + slot, axis, longest_x, longest_y))


@inline
def _slab(low_inverse, high_inverse, low_origin, high_origin, error, lo_plane, hi_plane):
    """Return the Slab of one axis from bounds of its rays; where directions differ in sign it lets everything pass."""
    near, far = lowest(low_inverse), highest(high_inverse)
    if near < 0 and far > 0:
        zero = np.float32(0)
        return Slab(lo_plane, zero, zero, zero, _HUGE, True)
    pad = max(abs(near), abs(far)) * error
    if far < 0:
        return Slab(hi_plane, far, -low_origin * far - pad, near, -high_origin * near + pad, False)
    return Slab(lo_plane, near, -high_origin * near - pad, far, -low_origin * far + pad, False)


@inline
def _least(a, b):
    return vector3(minimum(a.x, b.x), minimum(a.y, b.y), minimum(a.z, b.z))


@inline
def _greatest(a, b):
    return vector3(maximum(a.x, b.x), maximum(a.y, b.y), maximum(a.z, b.z))


@routine
def interval(words, packets, shared_origin):
    """Return the Interval of some packets of a RAY block; `shared_origin`: all start in one point."""
    slot = np.int64(count_trailing_zeros(packets)) * LANES
    low = high = load3(words, RAY.inverse + slot, SLOTS)
    low_origin = high_origin = load3(words, RAY.origin + slot, SLOTS)
    others = packets & (packets - 1)
    while others:
        slot = np.int64(count_trailing_zeros(others)) * LANES
        others &= others - 1
        inverse = load3(words, RAY.inverse + slot, SLOTS)
        low, high = _least(low, inverse), _greatest(high, inverse)
        if not shared_origin:
            origin = load3(words, RAY.origin + slot, SLOTS)
            low_origin, high_origin = _least(low_origin, origin), _greatest(high_origin, origin)
    x0 = x1 = extract(low_origin.x, 0)
    y0 = y1 = extract(low_origin.y, 0)
    z0 = z1 = extract(low_origin.z, 0)
    if not shared_origin:
        x0, y0, z0 = lowest(low_origin.x), lowest(low_origin.y), lowest(low_origin.z)
        x1, y1, z1 = highest(high_origin.x), highest(high_origin.y), highest(high_origin.z)
    error = highest(maximum(largest(low_origin), largest(high_origin))) * _ROUNDING
    x = _slab(low.x, high.x, x0, x1, error, NODE.lo_x, NODE.hi_x)
    y = _slab(low.y, high.y, y0, y1, error, NODE.lo_y, NODE.hi_y)
    z = _slab(low.z, high.z, z0, z1, error, NODE.lo_z, NODE.hi_z)
    octant = (x.near_plane == NODE.hi_x) + 2 * (y.near_plane == NODE.hi_y) + 4 * (z.near_plane == NODE.hi_z)
    return Interval(x, y, z, x.mixed or y.mixed or z.mixed, x.mixed and y.mixed and z.mixed, NODE.order + octant)


@inline
def fill_idle(active, v):
    """Return v with idle lanes holding the first active lane's value, so that they do not widen the packet."""
    if all_lanes(active):
        return v
    first = count_trailing_zeros(bits(active))
    return vector3(select(active, v.x, extract(v.x, first)), select(active, v.y, extract(v.y, first)),
                   select(active, v.z, extract(v.z, first)))
