"""Samples of a block of pixels added up.

A block's pixels are a grid with samples×samples for each, of which 8×8 make up a block of rays: rays that are so close
together go the same way.
"""

import numpy as np

from glimt.engines.cpu.kernels.block import PACKETS, SLOTS, lanes_of
from glimt.engines.cpu.kernels.create_rays import BLOCK_HEIGHT, BLOCK_WIDTH, PACKET_HEIGHT, PACKET_WIDTH
from glimt.engines.cpu.kernels.resolve import finite_samples
from glimt.kernel import inline
from glimt.lanes import LANES, lane_numbers, load3, scalar, scalar_int, shuffle, store3, store_scalar, vector3
from glimt.layout import MOST_SAMPLES

PLACE_WORDS = 2 * BLOCK_WIDTH * MOST_SAMPLES
_ROWS = PLACE_WORDS // 2


@inline
def _slot_of_column(x):
    return x // PACKET_WIDTH * LANES + x % PACKET_WIDTH


@inline
def _slot_of_row(y):
    return y // PACKET_HEIGHT * (BLOCK_WIDTH // PACKET_WIDTH) * LANES + y % PACKET_HEIGHT * PACKET_WIDTH


@inline
def put_places(places, samples):
    """Write what each column and each row of the grid say of the slot of its pixel, which is the sum of the two."""
    for number in range(BLOCK_WIDTH * samples):
        store_scalar(places, number, _slot_of_column(number // samples))
        store_scalar(places, _ROWS + number, _slot_of_row(number // samples))


@inline
def fours(v, first, second):
    """Return for each lane the sum of it and those whose numbers differ by the bits `first`, `second` or both."""
    pairs = v + shuffle(v, lane_numbers() ^ np.int32(first))
    return pairs + shuffle(pairs, lane_numbers() ^ np.int32(second))


@inline
def _add_to_places(totals, sums, places, column, row, step):
    """Add the samples in each `step`-th column and row to the totals of their pixels, row by row at any lane width."""
    for y in range(0, BLOCK_HEIGHT, step):
        below = scalar_int(places, _ROWS + row + y)
        for x in range(0, BLOCK_WIDTH, step):
            place, slot = np.int64(below + scalar_int(places, column + x)), _slot_of_row(y) + _slot_of_column(x)
            for plane in (0, SLOTS, 2 * SLOTS):
                store_scalar(totals, place + plane, scalar(totals, place + plane) + scalar(sums, slot + plane))


@inline
def add_samples(scene, totals, sums, inside, places, samples, column, row):
    """Add the samples from a column and row of the grid on to the totals of their pixels; `sums` is written to.

    Where a pixel has an even number of them on a side, all four of a square are of one.
    """
    even = samples % 2 == 0
    for k in range(PACKETS):
        slot = np.int64(k * LANES)
        light = finite_samples(scene, sums, slot, lanes_of(inside, slot))
        if samples == 1:
            store3(totals, slot, SLOTS, load3(totals, slot, SLOTS) + light)
        elif even:
            store3(sums, slot, SLOTS, vector3(
                fours(light.x, 1, PACKET_WIDTH), fours(light.y, 1, PACKET_WIDTH), fours(light.z, 1, PACKET_WIDTH)))
        else:
            store3(sums, slot, SLOTS, light)
    if even:
        _add_to_places(totals, sums, places, column, row, 2)
    elif samples > 1:
        _add_to_places(totals, sums, places, column, row, 1)
