"""A packet of rays, set up for boxes and for triangles in one space.

For boxes: planes are reached at ``plane * inverse + add``, where `near_add` and `far_add` are ``-origin * inverse``
moved apart by more than the rounding error of the origin (of its largest coordinate, since matrices mix them), so that
a box is never missed (after Ize, "Robust BVH ray traversal", 2013, with an absolute bound instead of a factor). The
interval of the whole packet answers for eight boxes at once.

For triangles: the shear that turns the ray into the z axis (Woop, Benthin, Wald, "Watertight ray/triangle
intersection", 2013).
"""

from typing import NamedTuple

import numpy as np

from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    absolute,
    all_lanes,
    any_lane,
    bits,
    count_trailing_zeros,
    extract,
    highest,
    lowest,
    maximum,
    reciprocal,
    select,
    vector3,
)
from glimt.layout import NODE

_SMALLEST = np.float32(2.0**-60)
"""The least component of a direction as a share of its greatest."""
_TINY = np.float32(1e-36)
_ROUNDING = np.float32(16 * 2.0**-24)
_ALL_LANES = np.int32((1 << LANES) - 1)
_HUGE = np.float32(3e38)
ANY_AXIS = 3
"""`axis` of a packet whose rays have different longest axes."""


class Slab(NamedTuple):
    """One axis of a packet: the word offset of the plane it meets first, and the interval's terms."""

    near_plane: object
    near_factor: object
    near_add: object
    far_factor: object
    far_add: object
    mixed: object


class Rays(NamedTuple):
    """Rays of a packet in one space; `t` means the same in all spaces."""

    origin: object
    direction: object
    inverse: object
    near_add: object
    far_add: object
    slab_x: object
    slab_y: object
    slab_z: object
    mixed: object
    incoherent: object
    mixed_pad: object
    axis: object
    longest_x: object
    longest_y: object
    shear: object
    shear_origin: object
    shared_origin: object


@inline
def _slab(direction, origin, inverse, error, shared_origin, lo_plane, hi_plane):
    """Return the Slab of one axis; where directions differ in sign it lets everything pass.

    `error` is the greatest of the packet's rounding errors of origins.
    """
    zero = np.float32(0)
    signs = bits(direction >= 0.0)
    if signs != 0 and signs != _ALL_LANES:
        return Slab(lo_plane, zero, zero, zero, _HUGE, True)
    lowest_origin, highest_origin = extract(origin, 0), extract(origin, 0)
    if not shared_origin:
        lowest_origin, highest_origin = lowest(origin), highest(origin)
    near, far, near_plane = lowest(inverse), highest(inverse), lo_plane
    pad = max(abs(near), abs(far)) * error
    if signs == 0:
        near, far, lowest_origin, highest_origin = far, near, highest_origin, lowest_origin
        near_plane = hi_plane
    return Slab(near_plane, near, -highest_origin * near - pad, far, -lowest_origin * far + pad, False)


@inline
def _inverse(d, least):
    """Return 1 / d, finite also where d is 0."""
    return reciprocal(select(absolute(d) < least, select(d < 0.0, -least, least), d))


@inline
def permute(longest_x, longest_y, v):
    """Return v with its components turned so that the longest axis is z."""
    return vector3(select(longest_x, v.y, select(longest_y, v.z, v.x)),
                   select(longest_x, v.z, select(longest_y, v.x, v.y)),
                   select(longest_x, v.x, select(longest_y, v.y, v.z)))


@inline
def set_up(origin, direction, shared_origin):
    """Return the Rays of a packet; every lane must hold a ray, `shared_origin` says that all start in one point."""
    d = direction
    ax, ay, az = absolute(d.x), absolute(d.y), absolute(d.z)
    least = maximum(maximum(ax, maximum(ay, az)) * _SMALLEST, _TINY)
    inverse = vector3(_inverse(d.x, least), _inverse(d.y, least), _inverse(d.z, least))
    add = vector3(-origin.x * inverse.x, -origin.y * inverse.y, -origin.z * inverse.z)
    error = maximum(absolute(origin.x), maximum(absolute(origin.y), absolute(origin.z))) * _ROUNDING
    pad = vector3(absolute(inverse.x) * error, absolute(inverse.y) * error, absolute(inverse.z) * error)
    greatest = extract(error, 0) if shared_origin else highest(error)
    slab_x = _slab(d.x, origin.x, inverse.x, greatest, shared_origin, NODE.lo_x, NODE.hi_x)
    slab_y = _slab(d.y, origin.y, inverse.y, greatest, shared_origin, NODE.lo_y, NODE.hi_y)
    slab_z = _slab(d.z, origin.z, inverse.z, greatest, shared_origin, NODE.lo_z, NODE.hi_z)

    # Shear along the longest axis of each ray, always the same one for the same ray.
    longest_x = (ax > ay) & (ax > az)
    longest_y = (ay >= ax) & (ay > az)
    axis = ANY_AXIS
    if all_lanes(longest_x):
        axis = 0
    elif all_lanes(longest_y):
        axis = 1
    elif not any_lane(longest_x | longest_y):
        axis = 2
    turned = permute(longest_x, longest_y, d)
    depth = reciprocal(turned.z)
    shear = vector3(turned.x * depth, turned.y * depth, depth)
    return Rays(origin, d, inverse, add - pad, add + pad, slab_x, slab_y, slab_z,
                slab_x.mixed or slab_y.mixed or slab_z.mixed, slab_x.mixed and slab_y.mixed and slab_z.mixed,
                maximum(pad.x, maximum(pad.y, pad.z)) * 2.0, axis, longest_x, longest_y, shear,
                permute(longest_x, longest_y, origin), shared_origin)


@inline
def fill_idle(active, v):
    """Return v with idle lanes holding the first active lane's value, so that they do not widen the packet."""
    if all_lanes(active):
        return v
    first = count_trailing_zeros(bits(active))
    return vector3(select(active, v.x, extract(v.x, first)), select(active, v.y, extract(v.y, first)),
                   select(active, v.z, extract(v.z, first)))
