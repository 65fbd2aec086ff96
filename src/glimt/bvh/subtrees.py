"""The kernels: growing and collapsing subtrees, laying out their nodes, and refitting them.

What threads share is handed out by `counter`, and what it writes depends on the place in the tree only.
"""

import numpy as np

from glimt.bvh.binned_sah import EMPTY, SPLIT_WORDS, split
from glimt.bvh.order import put_order
from glimt.bvh.wide import RECORD, WIDTH, collapse
from glimt.kernel import inline, kernel
from glimt.lanes import (
    atomic_add,
    f32x8,
    highest,
    load8,
    lowest,
    minimum,
    pointer,
    scalar,
    scalar_int,
    stack_floats,
    stack_ints,
    store8,
    store_scalar,
    store_scalar_int,
)
from glimt.layout import LEAF_SIZE, LEAF_STEP, NODE

CHUNK = 8192
"""Boxes that a thread prepares at a time."""

ID_TAG = np.int32(0x40000000)
"""Set in the id that a box carries in word 3, so that its bits are a normal float (denormal ones are slow)."""

SPLIT_ONCE, BUILD, COLLAPSE = 0, 1, 2

ROOT, DEPTH, START, STOP, FIRST_CUT, NODES, LEAVES, HEIGHT, NODE_BASE, LEAF_BASE, TASK_WORDS = range(11)
"""A task: a binary node and its depth, the binary nodes below it, where its wide nodes are listed; then, as results,
how many wide nodes and leaves it has and how deep it is; then where these begin in the tree."""


@kernel
def prepare_boxes(lo, hi, boxes, bounds, counter):
    """Write boxes (lo, id, -hi, 0) of primitives, and the bounds of each chunk of them."""
    n, low, high, target = len(lo), pointer(lo), pointer(hi), pointer(boxes)
    while True:
        chunk = atomic_add(counter, 0, 1)
        if chunk * CHUNK >= n:
            return
        whole = f32x8(EMPTY)
        for i in range(chunk * CHUNK, min(chunk * CHUNK + CHUNK, n)):
            for axis in range(3):
                store_scalar(target, 8 * i + axis, scalar(low, 3 * i + axis) + np.float32(0))  # no zero is negative
                store_scalar(target, 8 * i + 4 + axis, -(scalar(high, 3 * i + axis) + np.float32(0)))
            store_scalar(target, 8 * i + 7, np.float32(0))
            store_scalar_int(target, 8 * i + 3, ID_TAG | np.int32(i))
            whole = minimum(whole, load8(target, 8 * i))
        store8(bounds, 8 * chunk, whole)


@inline
def write_pair(meta, node, first, second):
    """Write both words about a binary node."""
    store_scalar(meta, 2 * node, first)
    store_scalar(meta, 2 * node + 1, second)


@inline
def grow(boxes, spare, nodes, meta, leaf_size, root, depth, next_node, most_splits):
    """Split a leaf of the binary tree, and what comes of it, until all are leaves that are best left alone.

    meta holds (left child, -1) or (first primitive, count); the two children of a node are neighbours. Return the
    first node that is still free.
    """
    memory, open_nodes = stack_floats(SPLIT_WORDS), stack_ints(512)
    store_scalar(open_nodes, 0, root)
    store_scalar(open_nodes, 1, depth)
    size = 1
    while size > 0 and most_splits > 0:
        size -= 1
        node, depth = np.int64(scalar_int(open_nodes, 2 * size)), scalar_int(open_nodes, 2 * size + 1)
        first, count = np.int64(scalar_int(meta, 2 * node)), np.int64(scalar_int(meta, 2 * node + 1))
        if count < 2:
            continue
        middle = split(boxes, spare, first, first + count, load8(nodes, RECORD * node), depth, leaf_size, memory,
                       nodes, RECORD * next_node)
        if middle < 0:
            continue
        write_pair(meta, node, next_node, -1)
        write_pair(meta, next_node, first, middle - first)
        write_pair(meta, next_node + 1, middle, first + count - middle)
        for side in range(1, -1, -1):  # right first, so that left is split next
            store_scalar(open_nodes, 2 * size, next_node + side)
            store_scalar(open_nodes, 2 * size + 1, depth + 1)
            size += 1
        next_node += 2
        most_splits -= 1
    return next_node


@kernel
def build_subtrees(boxes, spare, nodes, meta, cuts, leaf_size, tasks, mode, counter):
    """Split the roots of tasks once, or build and collapse their subtrees, or collapse what has been built."""
    none, most = np.int64(2 * (len(boxes) // 8) - 1), 1 if mode == SPLIT_ONCE else len(boxes)
    boxes_, spare_, nodes_, meta_, cuts_ = pointer(boxes), pointer(spare), pointer(nodes), pointer(meta), pointer(cuts)
    while True:
        k = atomic_add(counter, 0, 1)
        if k >= len(tasks):
            return
        root, depth, start, stop = tasks[k, ROOT], tasks[k, DEPTH], tasks[k, START], tasks[k, STOP]
        if mode != COLLAPSE:
            stop = grow(boxes_, spare_, nodes_, meta_, leaf_size, root, depth, start, most)
        if mode != SPLIT_ONCE:
            tasks[k, NODES], tasks[k, LEAVES], tasks[k, HEIGHT] = collapse(root, start, stop, nodes_, meta_, cuts_,
                                                                          tasks[k, FIRST_CUT], none)


@kernel
def lay_out(tasks, boxes, binary, meta, cuts, nodes, leaf_prims, counter):
    """Write the wide nodes and the leaf blocks of tasks to where they belong."""
    ids, source, pairs, chosen = pointer(boxes), pointer(binary), pointer(meta), pointer(cuts)
    target, prims = pointer(nodes), pointer(leaf_prims)
    while True:
        t = atomic_add(counter, 0, 1)
        if t >= len(tasks):
            return
        base, leaf, cut = NODE.words * tasks[t, NODE_BASE], tasks[t, LEAF_BASE], tasks[t, FIRST_CUT]
        for _ in range(tasks[t, NODES]):
            for k in range(WIDTH):
                child = np.int64(scalar_int(chosen, cut + k))
                for axis in range(3):
                    store_scalar(target, base + k + NODE.lo_x + 8 * axis, scalar(source, RECORD * child + axis))
                    store_scalar(target, base + k + NODE.hi_x + 8 * axis, -scalar(source, RECORD * child + 4 + axis))
                first, count = np.int64(scalar_int(pairs, 2 * child)), np.int64(scalar_int(pairs, 2 * child + 1))
                code = tasks[t, NODE_BASE] + first
                if count == 0:
                    code = np.int64(-1)
                elif count > 0:
                    code = ~(leaf * LEAF_STEP + count)
                    for j in range(LEAF_SIZE):
                        prim = scalar_int(ids, 8 * (first + j) + 3) & ~ID_TAG if j < count else np.int32(-1)
                        store_scalar(prims, LEAF_SIZE * leaf + j, prim)
                    leaf += 1
                store_scalar_int(target, base + k + NODE.child, code)
            put_order(target, base)
            base += NODE.words
            cut += WIDTH


@kernel
def refit_nodes(lo, hi, old_nodes, leaf_prims, nodes):
    """Bound children from the last node to the first: they come after their parents."""
    low, high, prims = pointer(lo), pointer(hi), pointer(leaf_prims)
    old, new = pointer(old_nodes), pointer(nodes)
    for base in range(len(nodes) - NODE.words, -1, -NODE.words):
        for row in range(0, NODE.words, WIDTH):
            store8(new, base + row, load8(old, base + row))
        for k in range(WIDTH):
            code = np.int64(scalar_int(old, base + NODE.child + k))
            if code >= 0:
                child = NODE.words * code
                for axis in range(3):
                    row = WIDTH * axis
                    store_scalar(new, base + row + k, lowest(load8(new, child + NODE.lo_x + row)))
                    store_scalar(new, base + NODE.hi_x + row + k, highest(load8(new, child + NODE.hi_x + row)))
            elif scalar(old, base + k) <= scalar(old, base + NODE.hi_x + k):
                block, count = ~code // LEAF_STEP, ~code % LEAF_STEP
                for axis in range(3):
                    least, most = np.float32(np.inf), np.float32(-np.inf)
                    for j in range(count):
                        prim = 3 * np.int64(scalar_int(prims, LEAF_SIZE * block + j)) + axis
                        least = min(least, scalar(low, prim) + np.float32(0))  # no zero is negative, as in `build`
                        most = max(most, scalar(high, prim) + np.float32(0))
                    store_scalar(new, base + WIDTH * axis + k, least)
                    store_scalar(new, base + NODE.hi_x + WIDTH * axis + k, most)
        put_order(new, base)
