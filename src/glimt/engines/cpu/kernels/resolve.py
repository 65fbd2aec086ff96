"""Stage 5: pixel samples to pixels."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import count
from glimt.engines.cpu.kernels.block import PACKETS, PATH, SLOTS
from glimt.engines.cpu.kernels.create_rays import PACKET_HEIGHT, PACKET_WIDTH, first_pixel
from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    absolute,
    bits,
    count_trailing_zeros,
    extract,
    f32,
    interleave4,
    load3,
    pointer,
    population_count,
    scalar,
    scalar_int,
    select3,
    splat3,
    store,
    store3,
    store_scalar,
)
from glimt.layout import COUNT_NON_FINITE

_LARGEST = np.float32(1e34)
"""Of samples below this, as many as a pixel may have still add up to a finite sum."""


@inline
def begin_pixels(sums):
    """Set three planes of sums to 0."""
    for k in range(PACKETS):
        store3(sums, np.int64(k * LANES), SLOTS, splat3(f32(0.0)))


@inline
def add_to_pixels(block, slot, lanes, light, depth):
    """Add light to the pixels that the rays of a packet come from; at depth 0 they are the packet's own."""
    if depth == 0:
        before = load3(block.sums, slot, SLOTS)
        store3(block.sums, slot, SLOTS, select3(lanes, before + light, before))
        return
    todo = bits(lanes)
    while todo:
        lane = count_trailing_zeros(todo)
        todo &= todo - 1
        at = np.int64(scalar_int(block.paths, PATH.pixel + slot + lane))
        store_scalar(block.sums, at, scalar(block.sums, at) + extract(light.x, lane))
        store_scalar(block.sums, at + SLOTS, scalar(block.sums, at + SLOTS) + extract(light.y, lane))
        store_scalar(block.sums, at + 2 * SLOTS, scalar(block.sums, at + 2 * SLOTS) + extract(light.z, lane))


@inline
def finite_samples(scene, sums, slot, inside):
    """Return the samples of a packet; one that is not finite, or would not add up, is counted and black."""
    radiance = load3(sums, slot, SLOTS)
    finite = ((absolute(radiance.x) < _LARGEST) & (absolute(radiance.y) < _LARGEST)
              & (absolute(radiance.z) < _LARGEST))
    count(scene, COUNT_NON_FINITE, population_count(bits(inside & ~finite)))
    return select3(finite, radiance, f32(0.0))


@inline
def resolve(film, totals, samples, left, top):
    """Write the totals of a block, and how many samples they have, to its pixels from (left, top) on."""
    height, width = film.shape[0], film.shape[1]
    words, count_ = pointer(film), f32(samples)
    for k in range(PACKETS):
        x, y = first_pixel(k, left, top)
        sums = load3(totals, np.int64(k * LANES), SLOTS)
        if x + PACKET_WIDTH <= width and y + PACKET_HEIGHT <= height:
            _store_quarter(words, x, y, width, 0, interleave4(sums.x, sums.y, sums.z, count_, 0))
            _store_quarter(words, x, y, width, 1, interleave4(sums.x, sums.y, sums.z, count_, 1))
            _store_quarter(words, x, y, width, 2, interleave4(sums.x, sums.y, sums.z, count_, 2))
            _store_quarter(words, x, y, width, 3, interleave4(sums.x, sums.y, sums.z, count_, 3))
        else:
            store_inside(words, x, y, width, height, sums, count_)


@inline
def store_inside(words, x, y, width, height, sums, samples):
    """Write those pixels of a packet, whose first one is (x, y), that are in the picture."""
    for lane in range(LANES):
        column, row = x + lane % PACKET_WIDTH, y + lane // PACKET_WIDTH
        if column < width and row < height:
            store_pixel(words, row * width + column, sums, lane, extract(samples, lane))


@inline
def store_pixel(words, pixel, sums, lane, samples):
    """Write one lane's sums, and how many samples they have, to a pixel of a film."""
    store_scalar(words, 4 * pixel, extract(sums.x, lane))
    store_scalar(words, 4 * pixel + 1, extract(sums.y, lane))
    store_scalar(words, 4 * pixel + 2, extract(sums.z, lane))
    store_scalar(words, 4 * pixel + 3, samples)


@inline
def _store_quarter(words, x, y, width, part, pixels):
    """Write a quarter of a packet: whole pixels of one row."""
    lane = part * (LANES // 4)
    store(words, 4 * ((y + lane // PACKET_WIDTH) * width + x + lane % PACKET_WIDTH), pixels)
