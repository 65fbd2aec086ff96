"""New boxes for a tree whose primitives have moved."""

import numpy as np
from numpy.typing import NDArray

from glimt.bvh.subtrees import refit_nodes
from glimt.bvh.wide import WideTree
from glimt.errors import GlimtError
from glimt.layout import aligned


def refit(tree: WideTree, lo: NDArray[np.float32], hi: NDArray[np.float32]) -> WideTree:
    """Return a tree of the same shape around new boxes of the same primitives.

    Linear in their number and several times faster than `build`. A ray's answer does not depend on the shape, its time
    does: good for bending and swaying, poor once neighbours part, since a node stays one node however far its
    primitives are from each other. As a rule of thumb, build again when `tree_stats(tree).sah_cost` has grown by half.

    Parameters
    ----------
    tree : WideTree
        Left as it is; the new tree shares its `leaf_prims`.
    lo, hi : (n, 3) float32
        Finite bounds of the n primitives of the tree, lo <= hi, below 1e15 in size.

    Raises
    ------
    GlimtError
        When there are not as many boxes as primitives.
    """
    count = int(tree.leaf_prims.max(initial=-1)) + 1
    if not lo.shape == hi.shape == (count, 3):
        raise GlimtError(f"the tree has {count} primitives, the new boxes are arrays of {lo.shape} and {hi.shape}, "
                         f"expected ({count}, 3); build a new tree when primitives come or go")
    if count == 0:
        return tree
    nodes = aligned(len(tree.nodes))
    refit_nodes(np.ascontiguousarray(lo, np.float32), np.ascontiguousarray(hi, np.float32), tree.nodes,
                tree.leaf_prims, nodes)
    return WideTree(nodes, tree.leaf_prims, tree.depth)
