"""Stage 5: pixel samples to pixels."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import count
from glimt.engines.cpu.kernels.create_rays import BLOCK_HEIGHT, BLOCK_WIDTH
from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    absolute,
    bits,
    extract,
    f32,
    interleave4,
    pointer,
    population_count,
    select3,
    store,
    store_scalar,
)
from glimt.layout import COUNT_NON_FINITE

_LARGEST = np.float32(1e34)
"""Of samples below this, as many as a pixel may have still add up to a finite sum."""


@inline
def drop_non_finite(scene, radiance, active):
    """Return radiance with samples that are not finite, or would not add up, replaced by black, and count them."""
    finite = ((absolute(radiance.x) < _LARGEST) & (absolute(radiance.y) < _LARGEST)
              & (absolute(radiance.z) < _LARGEST))
    count(scene, COUNT_NON_FINITE, population_count(bits(active & ~finite)))
    return select3(finite, radiance, f32(0.0))


@inline
def resolve(film, sums, samples, x, y):
    """Write the sums of a packet's samples, and how many there were, to its block of pixels at (x, y)."""
    height, width = film.shape[0], film.shape[1]
    words, count_ = pointer(film), f32(samples)
    if x + BLOCK_WIDTH <= width and y + BLOCK_HEIGHT <= height:
        _store_quarter(words, x, y, width, 0, interleave4(sums.x, sums.y, sums.z, count_, 0))
        _store_quarter(words, x, y, width, 1, interleave4(sums.x, sums.y, sums.z, count_, 1))
        _store_quarter(words, x, y, width, 2, interleave4(sums.x, sums.y, sums.z, count_, 2))
        _store_quarter(words, x, y, width, 3, interleave4(sums.x, sums.y, sums.z, count_, 3))
        return
    for lane in range(LANES):
        column, row = x + lane % BLOCK_WIDTH, y + lane // BLOCK_WIDTH
        if column < width and row < height:
            at = 4 * (row * width + column)
            store_scalar(words, at, extract(sums.x, lane))
            store_scalar(words, at + 1, extract(sums.y, lane))
            store_scalar(words, at + 2, extract(sums.z, lane))
            store_scalar(words, at + 3, samples)


@inline
def _store_quarter(words, x, y, width, part, pixels):
    """Write a quarter of a block: whole pixels of one row."""
    lane = part * (LANES // 4)
    store(words, 4 * ((y + lane // BLOCK_WIDTH) * width + x + lane % BLOCK_WIDTH), pixels)
