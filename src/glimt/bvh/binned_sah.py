"""Top-down binary tree over boxes by the binned surface area heuristic.

After Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007). What differs: a box is one register
``(lo, ., -hi, .)``, so that growing it is one minimum, and boxes themselves are moved instead of indices to them.
"""

import numpy as np

from glimt.kernel import inline, kernel, routine
from glimt.lanes import (
    atomic_add,
    extract,
    f32x8,
    join,
    load8,
    lower_half,
    maximum,
    minimum,
    scalar,
    scalar_int,
    select,
    stack_floats,
    stack_ints,
    store8,
    store_scalar,
    to_int,
    upper_half,
)

BINS = 16
FEW_BINS = 8
COST_INTERSECT = np.float32(8)
"""Cost of a leaf block of primitives in visits of a node: a node tests eight children at once, a leaf one
primitive after the other."""

MAX_SAH_DEPTH = 40
"""Below this depth ranges are halved by count: the whole tree stays under 40 + log2(n) levels, whatever the input."""

ID_TAG = np.int32(0x40000000)
"""Set in the id that a box carries in word 3, so that its bits are a normal float (denormal ones are slow)."""

_EMPTY = np.float32(3e38)
_RECORD = 4  # words of an open range: node, first, end, depth


@inline
def area(box):
    """Return half the surface area of a box."""
    extent = -(lower_half(box) + upper_half(box))
    x, y, z = extract(extent, 0), extract(extent, 1), extract(extent, 2)
    return x * y + y * z + z * x


@inline
def center_box(box):
    """Return twice the centre of a box as a box (c, -c)."""
    center = lower_half(box) - upper_half(box)
    return join(center, -center)


@inline
def bin_number(box, lowest, scale, bins):
    """Return the bin of a box on each axis."""
    position = (lower_half(box) - upper_half(box) - lowest) * scale
    return to_int(minimum(maximum(position, 0.0), np.float32(bins - 1)))


@inline
def blocks(count, leaf_size):
    """Return how many leaf blocks hold `count` primitives."""
    return np.float32((count + leaf_size - 1) // leaf_size)


@inline
def fill_bins(boxes, first, end, lowest, scale, bins, bin_boxes, bin_counts):
    """Grow each axis' bins by the boxes of a range."""
    for k in range(3 * bins):
        store8(bin_boxes, 8 * k, f32x8(_EMPTY))
        store_scalar(bin_counts, k, 0)
    for i in range(first, end):
        box = load8(boxes, 8 * i)
        number = bin_number(box, lowest, scale, bins)
        for axis in range(3):
            k = axis * bins + extract(number, axis)
            store8(bin_boxes, 8 * k, minimum(load8(bin_boxes, 8 * k), box))
            store_scalar(bin_counts, k, scalar_int(bin_counts, k) + 1)


@inline
def best_split(count, leaf_size, extent, bins, bin_boxes, bin_counts, right_costs):
    """Return (cost, axis, last bin on the left) of the cheapest split, axis -1 when there is none."""
    best, best_axis, best_bin = _EMPTY, -1, 0
    for axis in range(3):
        if extract(extent, axis) <= 0:
            continue
        grown, n = f32x8(_EMPTY), 0
        for j in range(bins - 1, 0, -1):
            k = axis * bins + j
            grown, n = minimum(grown, load8(bin_boxes, 8 * k)), n + scalar_int(bin_counts, k)
            store_scalar(right_costs, j, area(grown) * blocks(n, leaf_size) if n > 0 else np.float32(0))
        grown, n = f32x8(_EMPTY), 0
        for j in range(bins - 1):
            k = axis * bins + j
            grown, n = minimum(grown, load8(bin_boxes, 8 * k)), n + scalar_int(bin_counts, k)
            if 0 < n < count:
                cost = area(grown) * blocks(n, leaf_size) + scalar(right_costs, j + 1)
                if cost < best:
                    best, best_axis, best_bin = cost, axis, j
    return best, best_axis, best_bin


@inline
def halve(boxes, first, end, children):
    """Split a range in the middle, without moving anything."""
    middle = (first + end) // 2
    for side in range(2):
        whole, centers = f32x8(_EMPTY), f32x8(_EMPTY)
        for i in range(middle if side else first, end if side else middle):
            box = load8(boxes, 8 * i)
            whole, centers = minimum(whole, box), minimum(centers, center_box(box))
        store8(children, 16 * side, whole)
        store8(children, 16 * side + 8, centers)
    return middle


@inline
def partition(boxes, spare, first, end, axis, last, lowest, scale, bins, children):
    """Move the boxes of bins up to `last` to the front of the range, keeping order; without a branch per box."""
    left, left_centers = f32x8(_EMPTY), f32x8(_EMPTY)
    right, right_centers = left, left
    middle, moved = first, 0
    for i in range(first, end):
        box = load8(boxes, 8 * i)
        is_left = extract(bin_number(box, lowest, scale, bins), axis) <= last
        centers = center_box(box)
        store8(boxes, 8 * middle, box)
        store8(spare, 8 * (first + moved), box)
        apart, apart_centers = f32x8(_EMPTY), f32x8(_EMPTY)
        here = f32x8(np.float32(1) if is_left else np.float32(0)) > 0.5
        left, right = minimum(left, select(here, box, apart)), minimum(right, select(here, apart, box))
        left_centers = minimum(left_centers, select(here, centers, apart_centers))
        right_centers = minimum(right_centers, select(here, apart_centers, centers))
        middle += is_left
        moved += not is_left
    for i in range(moved):
        store8(boxes, 8 * (middle + i), load8(spare, 8 * (first + i)))
    store8(children, 0, left)
    store8(children, 8, left_centers)
    store8(children, 16, right)
    store8(children, 24, right_centers)
    return middle


@inline
def split(boxes, spare, first, end, whole, centers, depth, leaf_size, bin_boxes, bin_counts, right_costs,
          children):
    """Split a range where it costs least; return its middle, or -1 to make a leaf."""
    count = end - first
    lowest = lower_half(centers)
    extent = -(lowest + upper_half(centers))
    bins = BINS if count > 24 else FEW_BINS
    scale = select(extent > 0.0, np.float32(bins * 0.999) / extent, 0.0)
    fill_bins(boxes, first, end, lowest, scale, bins, bin_boxes, bin_counts)
    cost, axis, last = best_split(count, leaf_size, extent, bins, bin_boxes, bin_counts, right_costs)
    if count <= leaf_size:
        leaf_cost = COST_INTERSECT * blocks(count, leaf_size) * area(whole)
        if axis < 0 or leaf_cost <= area(whole) + COST_INTERSECT * cost:
            return -1
    if axis < 0 or depth >= MAX_SAH_DEPTH:
        return halve(boxes, first, end, children)
    return partition(boxes, spare, first, end, axis, last, lowest, scale, bins, children)


@kernel
def prepare_boxes(lo, hi, boxes, whole, first, end):
    """Write boxes (lo, id, -hi, 0) for a range of primitives, and their bounds and centre bounds to `whole`."""
    ids = boxes.view(np.int32)
    everything, centers = f32x8(_EMPTY), f32x8(_EMPTY)
    for i in range(first, end):
        for axis in range(3):
            boxes[8 * i + axis] = lo[i, axis]
            boxes[8 * i + 4 + axis] = -hi[i, axis]
        ids[8 * i + 3] = ID_TAG | i
        boxes[8 * i + 7] = 0
        box = load8(boxes, 8 * i)
        everything, centers = minimum(everything, box), minimum(centers, center_box(box))
    store8(whole, 0, everything)
    store8(whole, 8, centers)


@routine
def build_range(boxes, spare, bounds, meta, leaf_size, root, first, end, whole, depth, next_node, task_size, tasks,
                task_boxes):
    """Build the subtree of a range; ranges of at most `task_size` are left as tasks while there is room for them.

    bounds and meta describe the binary nodes: a box, and (left child, -1) or (first primitive, count). The two
    children of a node are neighbours. Return the number of tasks.
    """
    bin_boxes, bin_counts = stack_floats(384), stack_ints(48)
    right_costs, children = stack_floats(16), stack_floats(32)
    open_boxes, open_ranges = stack_floats(2048), stack_ints(512)
    store8(open_boxes, 0, load8(whole, 0))
    store8(open_boxes, 8, load8(whole, 8))
    for k, value in enumerate((root, first, end, depth)):
        store_scalar(open_ranges, k, value)
    size, task_count, room = 1, 0, len(tasks) // _RECORD
    while size > 0:
        size -= 1
        record = _RECORD * size
        node, first = np.int64(scalar_int(open_ranges, record)), np.int64(scalar_int(open_ranges, record + 1))
        end, depth = np.int64(scalar_int(open_ranges, record + 2)), scalar_int(open_ranges, record + 3)
        box, centers = load8(open_boxes, 16 * size), load8(open_boxes, 16 * size + 8)
        if end - first <= task_size and task_count < room:
            for k, value in enumerate((node, first, end, np.int64(depth))):
                tasks[_RECORD * task_count + k] = value
            store8(task_boxes, 16 * task_count, box)
            store8(task_boxes, 16 * task_count + 8, centers)
            task_count += 1
            continue
        store8(bounds, 8 * node, box)
        middle = np.int64(-1)
        if end - first > 1:
            middle = split(boxes, spare, first, end, box, centers, depth, leaf_size, bin_boxes, bin_counts,
                           right_costs, children)
        if middle < 0:
            meta[2 * node], meta[2 * node + 1] = first, end - first
            continue
        meta[2 * node], meta[2 * node + 1] = next_node, -1
        for side in range(1, -1, -1):  # right first, so that left is built next and lies nearer
            store8(open_boxes, 16 * size, load8(children, 16 * side))
            store8(open_boxes, 16 * size + 8, load8(children, 16 * side + 8))
            record = _RECORD * size
            store_scalar(open_ranges, record, next_node + side)
            store_scalar(open_ranges, record + 1, middle if side else first)
            store_scalar(open_ranges, record + 2, end if side else middle)
            store_scalar(open_ranges, record + 3, depth + 1)
            size += 1
        next_node += 2
    return task_count


@kernel
def build_tree(boxes, spare, bounds, meta, leaf_size, whole, task_size, tasks, task_boxes, counter):
    """Build the top of the tree (counter[0] < 0), or tasks of it, handed out by `counter`.

    With n boxes the root is node 2n and the top's nodes follow; the task of range [first, end) takes nodes from
    2 first.    Return the number of tasks left by the top.
    """
    n = len(boxes) // 8
    if counter[0] < 0:
        return build_range(boxes, spare, bounds, meta, leaf_size, 2 * n, 0, n, whole, 0, 2 * n + 1, task_size, tasks,
                           task_boxes)
    none, none_boxes = tasks[:0], task_boxes[:0]
    while True:
        k = atomic_add(counter, 0, 1)
        if k >= counter[1]:
            return 0
        node, first = tasks[_RECORD * k], tasks[_RECORD * k + 1]
        end, depth = tasks[_RECORD * k + 2], tasks[_RECORD * k + 3]
        build_range(boxes, spare, bounds, meta, leaf_size, node, first, end, task_boxes[16 * k:], depth, 2 * first, 0,
                    none, none_boxes)
