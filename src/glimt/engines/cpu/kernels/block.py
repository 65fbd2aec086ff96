"""Memory of a block: 64 rays, in as many packets as that takes, that travel together and stay in the first-level cache.

A field is a plane with one word for each ray: the words of ray number `slot` are at ``FIELD + slot``, and those of its
packet begin at a multiple of LANES. Which packets of a block are meant is told by the bits of an int32.
"""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from glimt.kernel import inline
from glimt.lanes import LANES, count_trailing_zeros, from_bits, scalar_int, stack_floats, stack_ints

SLOTS = 64
"""Rays in a block: an int64 has a bit for each."""
PACKETS = SLOTS // LANES

_PACKET_LANES, _PACKET_START = np.int64((1 << LANES) - 1), np.int64(-LANES)


def _planes(name: str, **components: int) -> Any:
    """Declare a record: the offset of each field, and `words` for a block of records."""
    offsets, offset = [], 0
    for count in components.values():
        offsets.append(offset)
        offset += count * SLOTS
    make: Any = namedtuple  # mypy wants literal names
    return make(name, [*components, "words"])(*offsets, offset)


RAY = _planes("RayPlanes", origin=3, direction=3, inverse=3, near_add=3, far_add=3, shear=2, longest=1, axis=1)
"""Rays in one space, set up for boxes and triangles (see `packet.Rays` and `packet.Shears`)."""

HIT = _planes("HitPlanes", t=1, u=1, v=1, prim=1, inst=1, clear=1, source=1, begin=1)
"""See `hit.Hit`. `clear`: a t before which a ray meets nothing of the instance `source`, which it leaves (MISS: none);
`begin`: where it begins in the tree of the instance at hand."""

SINGLE = _planes("SinglePlanes", near=3, order=1, axis=3)
"""What a ray needs to go by itself: word offsets of the planes it meets first, of the children's order, and of
the axes in its own order."""

PATH = _planes("PathPlanes", pixel=1, throughput=1, travelled=1, clear=1, source=1)
"""Where rays come from: their pixel's number in the block, the share of their light that arrives there, and the length
of the path so far; `clear` and `source` as in HIT."""

POINT = _planes("PointPlanes", point=3, start=3, ng=3, ns=3, clearance=1, clear_unit=1, diffuse=3, specular=3,
                exponent=1, reflectivity=1, lit=3, wi=3, cosine=1, arriving=1)
"""Surface points being shaded: `start` is where rays leave; `lit` is the light found so far; the rest of it, from wi
on, is that of one light."""

RAY_WORDS, HIT_WORDS, SINGLE_WORDS = RAY.words, HIT.words, SINGLE.words
PATH_WORDS, POINT_WORDS = PATH.words, POINT.words
SUM_WORDS = 3 * SLOTS
OCCLUDER_WORDS = 2 * 32
"""As plain numbers, which is what `stack_floats` takes."""


class Block(NamedTuple):
    """Pointers to the memory of one block.

    rays, hits: being traced; shadow_rays, shadow_hits; local: rays in the space of an instance; paths, points; sums:
    three planes of radiance, one word for each pixel; active: one int for each packet, the bits of its lanes that hold
    a ray, and found: of those that have hit something; occluders: for each light the instance and leaf that blocked
    all shadow rays of the last block (see `occluder`).
    """

    rays: object
    hits: object
    shadow_rays: object
    shadow_hits: object
    local: object
    paths: object
    points: object
    sums: object
    active: object
    found: object
    occluders: object


@inline
def new_block():
    """Return a block in the memory of the calling kernel."""
    return Block(stack_floats(RAY_WORDS), stack_floats(HIT_WORDS), stack_floats(RAY_WORDS), stack_floats(HIT_WORDS),
                 stack_floats(RAY_WORDS), stack_floats(PATH_WORDS), stack_floats(POINT_WORDS), stack_floats(SUM_WORDS),
                 stack_ints(PACKETS), stack_ints(PACKETS), stack_ints(OCCLUDER_WORDS))


@inline
def first_slot(packets):
    """Return the first slot of the first of some packets."""
    return np.int64(count_trailing_zeros(packets)) * LANES


@inline
def lanes_of(masks, slot):
    """Return the mask of a packet from `Block.active` or `Block.found`."""
    return from_bits(scalar_int(masks, slot // LANES))


@inline
def first_packet(lanes):
    """Return the first slot of the first packet that has a lane in an int64 with a bit for each ray of a block."""
    return np.int64(count_trailing_zeros(lanes)) & _PACKET_START


@inline
def lanes_of_packet(lanes, slot):
    """Return the lanes of one packet as bits of an int32."""
    return np.int32((lanes >> slot) & _PACKET_LANES)


@inline
def without_packet(lanes, slot):
    """Return lanes without those of a packet."""
    return lanes & ~(_PACKET_LANES << slot)


@inline
def all_lanes_of(packets):
    """Return all rays of some packets as bits of an int64."""
    lanes = np.int64(0)
    while packets:
        lanes |= _PACKET_LANES << first_slot(packets)
        packets &= packets - 1
    return lanes


@inline
def packets_of(lanes):
    """Return the packets that have a lane in an int64 with a bit for each ray of a block."""
    packets = np.int32(0)
    while lanes:
        slot = first_packet(lanes)
        lanes = without_packet(lanes, slot)
        packets |= np.int32(1) << np.int32(slot // LANES)
    return packets
