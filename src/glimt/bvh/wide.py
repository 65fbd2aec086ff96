"""Binary tree to a tree of eight children a node."""

from typing import NamedTuple

import numpy as np

from glimt.bvh.binned_sah import ID_TAG, area
from glimt.kernel import kernel
from glimt.lanes import load8
from glimt.layout import LEAF_SIZE, LEAF_STEP, NODE

WIDTH = 8
_EMPTY = np.float32(3e38)


class WideTree(NamedTuple):
    """A tree over boxes.

    nodes : (n * NODE.words,) float32
        NODE records; node 0 is the root.
    leaf_prims : (b, 4) int32
        Primitives of each leaf block, -1 where a block is not full.
    depth : int
        Nodes on the longest way down.
    """

    nodes: np.ndarray
    leaf_prims: np.ndarray
    depth: int


@kernel
def collapse(bounds, meta, ids, root, nodes, leaf_prims, sizes):
    """Open the largest inner child until a node has eight (Wald et al., "Getting rid of packets", 2008).

    sizes receives (number of nodes, number of leaf blocks, depth).
    """
    words = nodes.view(np.int32)
    stack = np.empty(3 * 1024, np.int64)
    child = np.empty(WIDTH, np.int64)
    stack[0], stack[1], stack[2] = root, 0, 1
    size, node_count, block_count, deepest = 1, 1, 0, 1
    while size > 0:
        size -= 1
        node, target, depth = stack[3 * size], stack[3 * size + 1], stack[3 * size + 2]
        deepest = max(deepest, depth)

        # Choose the children.
        n = 1
        child[0] = node
        while n < WIDTH:
            best, largest = -1, np.float32(-1)
            for k in range(n):
                if meta[2 * child[k] + 1] < 0:
                    this = area(load8(bounds, 8 * child[k]))
                    if this > largest:
                        best, largest = k, this
            if best < 0:
                break
            left = meta[2 * child[best]]
            child[best], child[n] = left, left + 1
            n += 1

        # Write them; inner ones are visited later, the first one next.
        base = target * NODE.words
        for k in range(WIDTH):
            for axis in range(3):
                nodes[base + NODE.lo_x + 8 * axis + k] = bounds[8 * child[k] + axis] if k < n else _EMPTY
                nodes[base + NODE.hi_x + 8 * axis + k] = -bounds[8 * child[k] + 4 + axis] if k < n else -_EMPTY
            words[base + NODE.child + k] = -1
            words[base + NODE.unused + k] = 0
            if k < n and meta[2 * child[k] + 1] < 0:
                words[base + NODE.child + k] = node_count
                node_count += 1
            elif k < n:
                first, count = meta[2 * child[k]], meta[2 * child[k] + 1]
                for j in range(LEAF_SIZE):
                    leaf_prims[block_count, j] = ids[8 * (first + j) + 3] & ~ID_TAG if j < count else -1
                words[base + NODE.child + k] = ~(block_count * LEAF_STEP + count)
                block_count += 1
        for k in range(n - 1, -1, -1):
            code = words[base + NODE.child + k]
            if code >= 0:
                stack[3 * size], stack[3 * size + 1], stack[3 * size + 2] = child[k], code, depth + 1
                size += 1
    sizes[0], sizes[1], sizes[2] = node_count, block_count, deepest
