"""A small picture stretched to a large one."""

import functools

import numpy as np
from numpy.typing import NDArray

from glimt.kernel import inline, kernel
from glimt.lanes import LANES, gather_pairs, i32, load_int, pointer, store

_PADDING = 16
"""Words that kernels may read and write beyond the end of a row: as many as there may be lanes."""


def stretch(small: NDArray[np.uint8], large: NDArray[np.uint8]) -> None:
    """Fill a picture with another, interpolated linearly between pixel centres (of sRGB codes, as screens do).

    Parameters
    ----------
    small, large : (h, w, 4) uint8
        Contiguous; `large` is written to.
    """
    height, width = large.shape[:2]
    rows, row_shares = _between(small.shape[0], height)
    columns, column_shares = _between(small.shape[1], width)
    words = small.reshape(-1).view(np.int32)
    space = np.empty((2, max(width, small.shape[1]) + 2 * _PADDING), np.int32)
    _stretch(words, small.shape[1], rows, row_shares, columns, column_shares, space,
             large.reshape(-1).view(np.int32).reshape(height, width))


@functools.lru_cache(64)
def _between(count: int, wanted: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return for each of `wanted` pixels the one before it of `count`, and how far it is to the next, in 1/256."""
    center = np.clip((np.arange(wanted + _PADDING) + 0.5) * (count / wanted) - 0.5, 0, count - 1)
    before = np.minimum(center.astype(np.int32), max(0, count - 2))
    return before, np.rint((center - before) * 256).astype(np.int32)


@inline
def _mix(a, b, share):  # type: ignore[no-untyped-def]
    """Return pixels that are `share` / 256 of the way from a to b: all four bytes of a word, two at a time."""
    pairs, half = np.int32(0x00FF00FF), np.int32(0x00800080)
    kept = 256 - share
    even = ((a & pairs) * kept + (b & pairs) * share + half) >> 8
    odd = ((a >> 8) & pairs) * kept + ((b >> 8) & pairs) * share + half
    return (even & pairs) | (odd & ~pairs)


@kernel
def _stretch(words, width, rows, row_shares, columns, column_shares, space, large):  # type: ignore[no-untyped-def]
    """Mix two rows into one, then neighbours of that one, into each row of `large`."""
    mixed, line = space[0], space[1]
    everywhere = i32(np.int32(0)) == i32(np.int32(0))
    for y in range(large.shape[0]):
        above, share = rows[y] * width, i32(row_shares[y])
        below = min(above + width, len(words) - width)
        x = 0
        while x + LANES <= width:
            store(mixed, x, _mix(load_int(words, above + x), load_int(words, below + x), share))
            x += LANES
        while x < width:
            mixed[x] = _mix(words[above + x], words[below + x], row_shares[y])
            x += 1
        mixed[width] = mixed[width - 1]
        for x in range(0, large.shape[1], LANES):
            left, right = gather_pairs(pointer(mixed), load_int(columns, x), everywhere)
            store(line, x, _mix(left, right, load_int(column_shares, x)))
        large[y, :] = line[:large.shape[1]]
