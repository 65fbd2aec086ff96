"""Stage 4: mirror rays, side by side again so that lanes stay full."""

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, PATH, POINT, RAY, SLOTS, first_slot, lanes_of
from glimt.engines.cpu.kernels.clearance import clear_until
from glimt.engines.cpu.kernels.resolve import add_to_pixels
from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    any_lane,
    bits,
    compress_store,
    compress_store3,
    dot,
    load,
    load3,
    load_int,
    maximum,
    normalize,
    population_count,
    select3,
    store_scalar,
)

_LEAST_RISE = np.float32(1e-3)
"""The least cosine between a mirror ray and the geometric normal."""


@inline
def mirror_direction(direction, ng, ns):
    """Return the direction of the mirror ray; one that a shading normal would send below the surface grazes it."""
    mirrored = direction - ns * (2.0 * dot(direction, ns))
    rise = dot(mirrored, ng)
    lifted = normalize(mirrored + ng * maximum(_LEAST_RISE - rise, 0.0))
    return select3(rise < _LEAST_RISE, lifted, mirrored)


@inline
def bounce(block, packets, depth, max_bounces):
    """Add what the surface points of some packets show to their pixels, and write the mirror rays that go on.

    The rays fill a block from its start: none is written where one is still to be read. Return its packets.
    """
    count = 0
    while packets:
        slot = first_slot(packets)
        packets &= packets - 1
        found = lanes_of(block.found, slot)
        throughput = load(block.paths, PATH.throughput + slot)
        reflectivity = load(block.points, POINT.reflectivity + slot)
        lit = load3(block.points, POINT.lit + slot, SLOTS)
        if depth == max_bounces:  # the last surface shows itself only
            add_to_pixels(block, slot, found, lit * throughput, depth)
            continue
        add_to_pixels(block, slot, found, lit * (throughput * (1.0 - reflectivity)), depth)
        onward = found & (reflectivity > 0.0)
        if any_lane(onward):
            direction = load3(block.rays, RAY.direction + slot, SLOTS)
            pixel, travelled = load_int(block.paths, PATH.pixel + slot), load(block.paths, PATH.travelled + slot)
            ng = load3(block.points, POINT.ng + slot, SLOTS)
            direction = mirror_direction(direction, ng, load3(block.points, POINT.ns + slot, SLOTS))
            start = load3(block.points, POINT.start + slot, SLOTS)
            clear = clear_until(load_int(block.points, POINT.clearance + slot),
                                load(block.points, POINT.clear_unit + slot), ng,
                                start - load3(block.points, POINT.point + slot, SLOTS), direction)
            source = load_int(block.hits, HIT.inst + slot)
            compress_store3(block.rays, RAY.origin + count, SLOTS, start, onward)
            compress_store3(block.rays, RAY.direction + count, SLOTS, direction, onward)
            compress_store(block.paths, PATH.throughput + count, throughput * reflectivity, onward)
            compress_store(block.paths, PATH.travelled + count, travelled, onward)
            compress_store(block.paths, PATH.pixel + count, pixel, onward)
            compress_store(block.paths, PATH.clear + count, clear, onward)
            compress_store(block.paths, PATH.source + count, source, onward)
            count += population_count(bits(onward))
    onward_packets = np.int32(0)
    for k in range((count + LANES - 1) // LANES):
        rest = np.int64(min(count - k * LANES, LANES))
        store_scalar(block.active, k, (np.int64(1) << rest) - 1)
        onward_packets |= np.int32(1) << np.int32(k)
    return onward_packets
