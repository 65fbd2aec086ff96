"""What a tree is worth."""

from typing import NamedTuple

import numpy as np

from glimt.bvh.wide import WIDTH, WideTree
from glimt.layout import LEAF_STEP, NODE


class TreeStats(NamedTuple):
    """Numbers of a tree.

    nodes, leaves : int
    depth : int
        Nodes on the longest way down.
    prims_per_leaf : float
    sah_cost : float
        Expected visits of nodes plus tests of primitives for a random ray that meets the root's box.
    memory_bytes : int
        Nodes and leaf ids.
    """

    nodes: int
    leaves: int
    depth: int
    prims_per_leaf: float
    sah_cost: float
    memory_bytes: int


def tree_stats(tree: WideTree) -> TreeStats:
    """Measure a tree; SAH cost with 1 for a node and 1 for a primitive."""
    words = tree.nodes.reshape(-1, NODE.words)
    codes = words[:, NODE.child:NODE.child + WIDTH].view(np.int32)
    sides = words[:, :NODE.child].astype(np.float64).reshape(-1, 2, 3, WIDTH)
    extent = sides[:, 1] - sides[:, 0]
    used = extent[:, 0] >= 0
    extent = np.where(used[:, None], extent, 0)
    areas = extent[:, 0] * extent[:, 1] + extent[:, 1] * extent[:, 2] + extent[:, 2] * extent[:, 0]
    root_lo = np.where(used[0], sides[0, 0], np.inf).min(1)
    root_hi = np.where(used[0], sides[0, 1], -np.inf).max(1)
    x, y, z = np.maximum(root_hi - root_lo, 0) if used[0].any() else np.zeros(3)
    root_area = x * y + y * z + z * x
    is_leaf = used & (codes < 0)
    counts = np.where(is_leaf, ~codes & (LEAF_STEP - 1), 0)
    cost = 1.0 + float((areas * (used & (codes >= 0))).sum() + (areas * counts).sum()) / root_area if root_area else 1.0
    leaves = int(is_leaf.sum())
    return TreeStats(len(words), leaves, tree.depth, float(counts.sum()) / max(1, leaves), cost,
                     tree.nodes.nbytes + tree.leaf_prims.nbytes)
