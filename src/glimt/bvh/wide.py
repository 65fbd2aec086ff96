"""Binary tree to a tree of eight children a node."""

from typing import NamedTuple

import numpy as np

from glimt.bvh.binned_sah import EMPTY, area
from glimt.kernel import inline
from glimt.lanes import (
    extract,
    f32x8,
    load8,
    minimum,
    scalar,
    scalar_int,
    stack_floats,
    stack_ints,
    store8,
    store_scalar,
)

WIDTH = 8
RECORD = 16
"""Words of a binary node: its box, then what it costs to have its primitives in 1 to 8 children of a wide node."""


class WideTree(NamedTuple):
    """A tree over boxes.

    nodes : (n * NODE.words,) float32
        NODE records; node 0 is the root, children come after their parents.
    leaf_prims : (b, 4) int32
        Primitives of each leaf block, -1 where a block is not full.
    depth : int
        Nodes on the longest way down.
    """

    nodes: np.ndarray
    leaf_prims: np.ndarray
    depth: int


@inline
def weigh(node, start, nodes, meta, shifted):
    """Write what a binary node costs: the areas of all wide nodes in its subtree.

    ``c[k] = min(c[1], min over i of left[i] + right[k - i])``, ``c[1] = area + c[8]``; nothing for a leaf.
    """
    left = np.int64(scalar_int(meta, 2 * node))
    if scalar_int(meta, 2 * node + 1) >= 0 or left < start:
        store8(nodes, RECORD * node + 8, f32x8(0))
        return
    store8(shifted, 8, load8(nodes, RECORD * (left + 1) + 8))
    best = f32x8(EMPTY)
    for i in range(1, WIDTH):
        best = minimum(best, load8(shifted, 8 - i) + scalar(nodes, RECORD * left + 7 + i))
    alone = area(load8(nodes, RECORD * node)) + extract(best, WIDTH - 1)
    store8(nodes, RECORD * node + 8, minimum(best, f32x8(alone)))


@inline
def choose_children(root, start, nodes, meta, chosen):
    """Write the up to eight children of the wide node that begins at a binary node; return how many."""
    open_nodes = stack_ints(16)
    store_scalar(open_nodes, 0, root)
    store_scalar(open_nodes, 1, WIDTH)
    size, n = 1, 0
    while size > 0:
        size -= 1
        node, room = np.int64(scalar_int(open_nodes, 2 * size)), scalar_int(open_nodes, 2 * size + 1)
        left, best, share = np.int64(scalar_int(meta, 2 * node)), np.float32(np.inf), 0
        if scalar_int(meta, 2 * node + 1) < 0 and left >= start:
            for i in range(1, room):
                cost = scalar(nodes, RECORD * left + 7 + i) + scalar(nodes, RECORD * (left + 1) + 7 + room - i)
                if cost < best or (cost == best and 2 * i <= room):
                    best, share = cost, i
        if share == 0 or (node != root and best > scalar(nodes, RECORD * node + 8)):
            store_scalar(chosen, n, node)
            n += 1
            continue
        store_scalar(open_nodes, 2 * size, left + 1)
        store_scalar(open_nodes, 2 * size + 1, room - share)
        store_scalar(open_nodes, 2 * size + 2, left)
        store_scalar(open_nodes, 2 * size + 3, share)
        size += 2
    return n


@inline
def collapse(root, start, stop, nodes, meta, cuts, first_cut, none):
    """Cut the binary nodes [start, stop) below a root into wide nodes so that the sum of their areas is least.

    By dynamic programming, after Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through
    compressed wide BVHs" (2017), with leaves as they are. cuts receives the binary nodes that are the children of
    each wide node, `none` where there are fewer than eight; a binary node that begins a wide one receives its number as
    left child. Inner nodes whose children lie before `start` begin wide nodes elsewhere: they receive -1 - depth as
    their count. Return (number of wide nodes, number of leaves, depth).
    """
    shifted, chosen, open_nodes = stack_floats(16), stack_ints(8), stack_ints(3072)
    store8(shifted, 0, f32x8(EMPTY))
    for node in range(stop - 1, start - 1, -1):
        weigh(node, start, nodes, meta, shifted)
    store_scalar(open_nodes, 0, root)
    store_scalar(open_nodes, 1, 0)
    store_scalar(open_nodes, 2, 1)
    size, wide_nodes, leaves, deepest = 1, np.int64(1), np.int64(0), np.int64(0)
    while size > 0:
        size -= 1
        node, target = np.int64(scalar_int(open_nodes, 3 * size)), np.int64(scalar_int(open_nodes, 3 * size + 1))
        depth = scalar_int(open_nodes, 3 * size + 2)
        deepest = max(deepest, np.int64(depth))
        n = choose_children(node, start, nodes, meta, chosen)
        if scalar_int(meta, 2 * node + 1) < 0:
            store_scalar(meta, 2 * node, target)
        for k in range(WIDTH - 1, -1, -1):  # the first child is opened next
            child = np.int64(scalar_int(chosen, k)) if k < n else none
            store_scalar(cuts, first_cut + WIDTH * target + k, child)
            if k < n and scalar_int(meta, 2 * child + 1) >= 0:
                leaves += 1
            elif k < n and scalar_int(meta, 2 * child) < start:
                store_scalar(meta, 2 * child + 1, -1 - depth)
            elif k < n:
                store_scalar(open_nodes, 3 * size, child)
                store_scalar(open_nodes, 3 * size + 1, wide_nodes)
                store_scalar(open_nodes, 3 * size + 2, depth + 1)
                wide_nodes += 1
                size += 1
    return wide_nodes, leaves, deepest
