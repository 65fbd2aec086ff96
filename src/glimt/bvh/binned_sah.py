"""Where to split a range of boxes: the surface area heuristic, over bins or, for a few boxes, over every split.

After Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007). What differs: a box is one register
``(lo, ., -hi, .)``, so that growing it is one minimum; boxes themselves are moved instead of indices to them; and what
all splits of a range cost is computed side by side in lanes.
"""

import numpy as np

from glimt.kernel import inline
from glimt.lanes import (
    bits,
    count_trailing_zeros,
    extract,
    f32x8,
    floor,
    interleave4,
    least_number,
    load4,
    load8,
    lower_half,
    lowest,
    maximum,
    minimum,
    scalar,
    select,
    store8,
    store_scalar,
    to_int,
    upper_half,
)

FEW = 8
"""Up to this many boxes are sorted on each axis, and every split between two of them is considered."""

BINS, COARSE_BINS, COARSE_UP_TO = 16, 8, 64

SAMPLE_FROM, SAMPLE_STEP = 1024, 4
"""Of more boxes than this only every fourth is binned: all are moved, and bounded exactly."""

COST_INTERSECT = np.float32(4)
"""Cost of a leaf block of primitives in visits of a node."""

MAX_SAH_DEPTH = 40
"""Below this depth ranges are halved by count: the whole tree stays under 44 + log2(n) levels, whatever the input."""

EMPTY = np.float32(3e38)

BIN_BOXES, BIN_COUNTS = 0, 32 * BINS
LEFT_COUNTS, LEFT_AREAS, RIGHT_AREAS = 36 * BINS, 40 * BINS, 44 * BINS + 4
SPLIT_WORDS = 48 * BINS + 8
"""Offsets into the memory of `split`, which is as many words: for each bin and axis (of which there are four, the last
one never used) a box and a number of boxes; then the number on the left of a split after the bin, and half areas."""


@inline
def area(box):
    """Return half the surface area of a box."""
    extent = -(lower_half(box) + upper_half(box))
    x, y, z = extract(extent, 0), extract(extent, 1), extract(extent, 2)
    return x * y + y * z + z * x


@inline
def center_of(boxes, i):
    """Return twice the centre of box i."""
    box = load8(boxes, 8 * i)
    return lower_half(box) - upper_half(box)


@inline
def areas(x, y, z):
    """Return half the surface areas of three boxes, as the first three of four lanes."""
    x, y, z = lower_half(x) + upper_half(x), lower_half(y) + upper_half(y), lower_half(z) + upper_half(z)
    a, b, c = interleave4(x, y, z, z, 0), interleave4(x, y, z, z, 1), interleave4(x, y, z, z, 2)
    return a * b + b * c + c * a


@inline
def bin_box(memory, number, axis):
    """Return the box of a bin."""
    return load8(memory, BIN_BOXES + 32 * number + 8 * axis)


@inline
def clear_bins(bins, memory):
    """Empty the bins."""
    for number in range(bins):
        for axis in range(3):
            store8(memory, BIN_BOXES + 32 * number + 8 * axis, f32x8(EMPTY))
    for k in range(0, 4 * bins, 8):
        store8(memory, BIN_COUNTS + k, f32x8(0))


@inline
def add_to_bins(boxes, i, low, scale, bins, memory):
    """Grow a bin of each axis by box i."""
    box = load8(boxes, 8 * i)
    position = (lower_half(box) - upper_half(box) - low) * scale
    numbers = to_int(minimum(maximum(position, 0.0), np.float32(bins - 1)))
    for axis in range(3):
        number = np.int64(extract(numbers, axis))
        store8(memory, BIN_BOXES + 32 * number + 8 * axis, least_number(bin_box(memory, number, axis), box))
        count = BIN_COUNTS + 4 * number + axis
        store_scalar(memory, count, scalar(memory, count) + np.float32(1))


@inline
def fill_bins(boxes, first, count, step, low, scale, bins, memory):
    """Grow the bins of each axis by `count` boxes of a range, by their centres."""
    clear_bins(bins, memory)
    half = count // 2
    for i in range(half):  # two places in turn, so that few additions wait for the one before
        add_to_bins(boxes, first + i * step, low, scale, bins, memory)
        add_to_bins(boxes, first + (i + half) * step, low, scale, bins, memory)
    if 2 * half < count:
        add_to_bins(boxes, first + (count - 1) * step, low, scale, bins, memory)


@inline
def sort_few(boxes, first, count, memory):
    """Put the boxes of a small range in order on each axis, by their centres: one in each of `FEW` bins."""
    clear_bins(FEW, memory)
    for i in range(count):
        center = center_of(boxes, first + i)
        rank = center * 0.0
        one = rank + 1.0
        for j in range(i):
            rank = rank + select(center_of(boxes, first + j) <= center, one, 0.0)
        for j in range(i + 1, count):
            rank = rank + select(center_of(boxes, first + j) < center, one, 0.0)
        numbers = to_int(rank)
        for axis in range(3):
            number = np.int64(extract(numbers, axis))
            store8(memory, BIN_BOXES + 32 * number + 8 * axis, load8(boxes, 8 * (first + i)))
            store_scalar(memory, BIN_COUNTS + 4 * i + axis, np.float32(1))


@inline
def sweep(bins, memory):
    """Write the areas of what lies left and right of each split, and the count of what lies left."""
    left_x, left_y, left_z = f32x8(EMPTY), f32x8(EMPTY), f32x8(EMPTY)
    right_x, right_y, right_z = left_x, left_x, left_x
    n = load4(memory, BIN_COUNTS) * 0.0
    for j in range(bins):
        left_x, left_y = least_number(left_x, bin_box(memory, j, 0)), least_number(left_y, bin_box(memory, j, 1))
        left_z = least_number(left_z, bin_box(memory, j, 2))
        n = n + load4(memory, BIN_COUNTS + 4 * j)
        store8(memory, LEFT_COUNTS + 4 * j, n)
        store8(memory, LEFT_AREAS + 4 * j, areas(left_x, left_y, left_z))
        k = bins - 1 - j
        right_x, right_y = least_number(right_x, bin_box(memory, k, 0)), least_number(right_y, bin_box(memory, k, 1))
        right_z = least_number(right_z, bin_box(memory, k, 2))
        store8(memory, RIGHT_AREAS + 4 * (k - 1), areas(right_x, right_y, right_z))


@inline
def best_split(count, leaf_size, bins, memory):
    """Return (cost, 4 * last bin on the left + axis) of the cheapest split, -1 when there is none."""
    best, where = EMPTY, np.int64(-1)
    whole, share, last = np.float32(count), np.float32(1) / np.float32(leaf_size), np.float32(leaf_size - 1)
    for k in range(0, 4 * bins, 8):
        n = load8(memory, LEFT_COUNTS + k)
        left, right = floor((n + last) * share), floor((whole - n + last) * share)  # in leaf blocks
        cost = load8(memory, LEFT_AREAS + k) * left + load8(memory, RIGHT_AREAS + k) * right
        cost = select((n > 0.0) & (n < whole), cost, EMPTY)
        least = lowest(cost)
        if least < best:
            best, where = least, np.int64(k + count_trailing_zeros(bits(cost == least)))
    return best, where


@inline
def bound(boxes, first, end):
    """Return the box around a range."""
    even = odd = load8(boxes, 8 * (end - 1))
    for i in range(first, end - 1, 2):  # two at a time, since each minimum waits for the one before
        even, odd = least_number(even, load8(boxes, 8 * i)), least_number(odd, load8(boxes, 8 * i + 8))
    return least_number(even, odd)


@inline
def join_bins(bins, axis, last, memory, children, target):
    """Write the boxes of both sides of a split."""
    left, right = f32x8(EMPTY), f32x8(EMPTY)
    for j in range(last + 1):
        left = least_number(left, bin_box(memory, j, axis))
    for j in range(last + 1, bins):
        right = least_number(right, bin_box(memory, j, axis))
    store8(children, target, left)
    store8(children, target + 16, right)


@inline
def partition(boxes, spare, first, end, axis, last, low, scale):
    """Move the boxes of bins up to `last` to the front of the range, keeping order; without a branch per box."""
    middle, moved, edge = first, first, np.float32(last + 1)
    for i in range(first, end):
        box = load8(boxes, 8 * i)
        position = (scalar(boxes, 8 * i + axis) - scalar(boxes, 8 * i + 4 + axis) - low) * scale
        is_left = not position >= edge  # as in the bins where a range is so small that this is not a number
        store8(boxes, 8 * middle, box)
        store8(spare, 8 * moved, box)
        middle += is_left
        moved += not is_left
    for i in range(end - middle):
        store8(boxes, 8 * (middle + i), load8(spare, 8 * (first + i)))
    return middle


@inline
def split(boxes, spare, first, end, whole, depth, leaf_size, memory, children, target):
    """Split a range where it costs least; return its middle, or -1 to make a leaf.

    The boxes of both sides go to words `target` and `target` + 16 of `children`.
    """
    count = end - first
    low, high = load4(boxes, 0) * 0.0, load4(boxes, 0) * 0.0
    scale, bins, sampled = low, FEW, count
    if count <= FEW:
        sort_few(boxes, first, count, memory)
    else:
        step = 1 if count <= SAMPLE_FROM else SAMPLE_STEP
        sampled = (count + step - 1) // step
        bins = COARSE_BINS if count <= COARSE_UP_TO else BINS
        low, high = low + EMPTY, high - EMPTY
        for i in range(first, end, step):
            center = center_of(boxes, i)
            low, high = minimum(low, center), maximum(high, center)
        scale = select(high > low, np.float32(bins * 0.999) / (high - low), 0.0)
        fill_bins(boxes, first, sampled, step, low, scale, bins, memory)
    sweep(bins, memory)
    cost, where = best_split(sampled, leaf_size, bins, memory)
    if count <= leaf_size:
        leaf_cost = COST_INTERSECT * area(whole)
        if where < 0 or leaf_cost <= area(whole) + COST_INTERSECT * cost:
            return np.int64(-1)
    axis, last, middle = where & 3, where >> 2, first + count // 2
    if where < 0 or depth >= MAX_SAH_DEPTH:
        sampled = 0
    elif count <= FEW:
        for i in range(count):
            store8(boxes, 8 * (first + i), bin_box(memory, i, axis))
        middle = first + last + 1
    else:
        middle = partition(boxes, spare, first, end, axis, last, extract(low, axis), extract(scale, axis))
    if sampled == count:
        join_bins(bins, axis, last, memory, children, target)
    else:
        store8(children, target, bound(boxes, first, middle))
        store8(children, target + 16, bound(boxes, middle, end))
    return middle
