"""A scene's trees in nodes of 80 bytes instead of 256, for engines that wait for memory more than they compute.

After Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs" (2017). What
differs: a leaf is a block of up to four triangles side by side instead of a run of triangles, children are given to
slots at the least cost by dynamic programming instead of by auction, and a byte of `meta` holds a child's rank.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.layout import (
    COMPRESSED_NODE,
    INNER_META,
    INSTANCE,
    INSTANCE_BLOCK,
    LEAF_META,
    LEAF_STEP,
    MESH_KIND,
    NODE,
    TRIANGLE_BLOCK,
    dtype,
)
from glimt.packed.packed_scene import PackedScene, Words

_CHUNK = 2048  # nodes at a time: what that takes fits a cache
_WIDTH = 8
_SLOT_BITS = 1 << np.arange(_WIDTH)
_CORNERS = np.where(np.arange(_WIDTH)[:, None] >> np.arange(3) & 1, 1, -1).astype(np.float32)
_LEAST_EXPONENT = -126  # of float32s that no GPU takes for 0
_GRID = 2.0**_LEAST_EXPONENT
_ULP_EXPONENT = 25  # 2**(x - 25) is at most the distance from a float32 in 2**(x - 1) to 2**x to the next

_SUBSETS = [np.array([subset for subset in range(256) if subset.bit_count() == size]) for size in range(1, _WIDTH + 1)]
_MEMBERS = [np.array([np.flatnonzero(subset & _SLOT_BITS) for subset in subsets]) for subsets in _SUBSETS]


class CompressedTree(NamedTuple):
    """One or more trees over leaf blocks, level by level.

    nodes : (n * COMPRESSED_NODE.words,) uint32
        Inner children of a node lie side by side in slot order, and so do its leaves' blocks. Never empty: one node of
        zeros, which has no children, for no tree.
    blocks : (b,) int64
        The number that the block of each leaf had before.
    counts : (b,) int32
        How many things are in each.
    depth : int
        Nodes on the longest way down.
    """

    nodes: NDArray[np.uint32]
    blocks: NDArray[np.int64]
    counts: NDArray[np.int32]
    depth: int


class CompressedTrees(NamedTuple):
    """The trees of a scene; no array of nodes or blocks is empty.

    blas_nodes, tlas_nodes : uint32
        COMPRESSED_NODE words. The root of the scene's tree is node 0.
    blas_blocks : uint32
        TRIANGLE_BLOCK words in the order of leaves.
    tlas_instances : (b,) int32
        The instance in each leaf of the scene's tree: its `block_base` counts here. Empty for a scene without any.
    roots : (i,) int32
        The root of the mesh of each instance record, -1 for a sphere.
    blas_depth, tlas_depth : int
        Nodes on the longest way down, of meshes the deepest.
    """

    blas_nodes: NDArray[np.uint32]
    blas_blocks: NDArray[np.uint32]
    tlas_nodes: NDArray[np.uint32]
    tlas_instances: NDArray[np.int32]
    roots: NDArray[np.int32]
    blas_depth: int
    tlas_depth: int


def compress(scene: PackedScene, before: CompressedTrees | None = None) -> CompressedTrees:
    """Return the trees of a scene in compressed nodes.

    Parameters
    ----------
    before : CompressedTrees, optional
        Of a scene whose `blas_nodes` and `blas_blocks` are the same objects, as when only instances have moved: its
        meshes are taken over, and only the scene's own tree is new.
    """
    upper = compress_tree(scene.tlas_nodes, np.zeros(1, np.int32))
    if (upper.counts != 1).any():
        raise AssertionError("a leaf of the scene's tree has more than one instance")
    instances = scene.tlas_blocks.view(dtype(INSTANCE_BLOCK))["instance"][upper.blocks, 0]
    records = scene.instances.view(dtype(INSTANCE))
    placed = instances[records["kind"][instances] == MESH_KIND]  # a scene without instances has a record never read
    old_roots, which = np.unique(records["root"][placed], return_inverse=True)
    roots = np.full(len(records), -1, np.int32)
    roots[placed] = which
    if before:
        return before._replace(tlas_nodes=upper.nodes, tlas_instances=instances, roots=roots, tlas_depth=upper.depth)
    lower = compress_tree(scene.blas_nodes, old_roots)
    blocks = scene.blas_blocks.view(np.uint32).reshape(-1, TRIANGLE_BLOCK.words)[lower.blocks].ravel()
    return CompressedTrees(
        blas_nodes=lower.nodes, blas_blocks=blocks if blocks.size else np.zeros(TRIANGLE_BLOCK.words, np.uint32),
        tlas_nodes=upper.nodes, tlas_instances=instances, roots=roots,
        blas_depth=lower.depth, tlas_depth=upper.depth)


def compress_tree(nodes: Words, roots: NDArray[np.int32]) -> CompressedTree:
    """Return trees in compressed nodes.

    Parameters
    ----------
    nodes : float32
        NODE words; coordinates below 1e36 in size.
    roots : (r,) int32
        A node for each tree, no two the same: they become nodes 0 to r - 1.
    """
    words = nodes.reshape(-1, NODE.words)
    if not len(roots):
        words = words[:0]  # a record that is never read
    order = np.empty((len(words), _WIDTH), np.uint8)
    for first in range(0, len(words), _CHUNK):
        order[first:first + _CHUNK] = _slot_order(words[first:first + _CHUNK])
    codes = np.take_along_axis(words[:, NODE.child:NODE.order].view(np.int32), order, 1)
    levels = [np.asarray(roots, np.int64)]
    while len(levels[-1]):
        below = codes[levels[-1]]
        levels.append(below[below >= 0].astype(np.int64))
    number = np.concatenate(levels)
    compressed, blocks, counts = _link(codes[number], len(roots))
    for first in range(0, len(number), _CHUNK):
        some = number[first:first + _CHUNK]
        _quantise(words[some], order[some], compressed[first:first + _CHUNK])
    if not len(compressed):
        compressed = np.zeros((1, COMPRESSED_NODE.words), np.uint32)
    return CompressedTree(compressed.ravel(), blocks, counts, max(1, len(levels) - 1))


def _boxes(words: Words) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return (lo, hi, used) of children, (n, 3, 8) twice and (n, 1, 8); boxes of those that are not used are (0, 0)."""
    codes = words[:, None, NODE.child:NODE.order].view(np.int32)
    used = (codes >= 0) | (~codes % LEAF_STEP > 0)
    sides = words[:, :NODE.child].reshape(-1, 2, 3, _WIDTH)
    lo, hi = (np.where(used, sides[:, k], 0).astype(np.float64) for k in range(2))
    return lo, hi, used


def _slot_order(words: Words) -> NDArray[np.uint8]:
    """Return the child for each slot, (n, 8), by least cost.

    Giving a child to a slot costs how far its centre is from the middle of the node against the direction to the slot's
    corner. The least cost of the first k children for each set of k slots follows from that of one child less.
    """
    lo, hi, used = _boxes(words)
    low = np.where(used, lo, np.inf).min(2, keepdims=True)
    high = np.where(used, hi, -np.inf).max(2, keepdims=True)
    with np.errstate(invalid="ignore"):  # a node without children
        offsets = np.where(used, (lo + hi) - (low + high), 0)
    cost = -_CORNERS @ offsets.transpose(2, 1, 0).astype(np.float32)  # child, slot, node
    least = np.zeros((1 << _WIDTH, len(words)), np.float32)
    for child, (subsets, slots) in enumerate(zip(_SUBSETS, _MEMBERS, strict=True)):
        least[subsets] = (least[subsets[:, None] ^ _SLOT_BITS[slots]] + cost[child, slots]).min(1)
    each, free = np.arange(len(words)), np.full(len(words), (1 << _WIDTH) - 1)
    order = np.empty((len(words), _WIDTH), np.uint8)
    for child in range(_WIDTH - 1, -1, -1):
        bits = _SLOT_BITS[:, None] & free
        slot = np.where(bits, least[free ^ bits, each] + cost[child], np.inf).argmin(0)
        order[each, slot] = child
        free ^= _SLOT_BITS[slot]
    return order


def _link(codes: NDArray[np.int32], roots: int) -> tuple[NDArray[np.uint32], NDArray[np.int64], NDArray[np.int32]]:
    """Return nodes that have all but their boxes, and (block, count) of leaves, from child codes in slot order."""
    inner, counts = codes >= 0, np.where(codes < 0, ~codes % LEAF_STEP, 0)
    leaf = counts > 0
    nodes = np.zeros((len(codes), COMPRESSED_NODE.words), np.uint32)
    nodes[:, COMPRESSED_NODE.exponents] = np.packbits(inner, 1, "little")[:, 0].astype(np.uint32) << 24
    for field, which, first in ((COMPRESSED_NODE.child_base, inner, roots), (COMPRESSED_NODE.block_base, leaf, 0)):
        children = which.sum(1)
        nodes[:, field] = first + np.cumsum(children) - children
    meta = np.where(inner, INNER_META | (np.cumsum(inner, 1) - 1), 0)
    meta = np.where(leaf, LEAF_META | (np.cumsum(leaf, 1) - 1) * LEAF_STEP + counts, meta).astype(np.uint8)
    nodes[:, COMPRESSED_NODE.meta:COMPRESSED_NODE.lo_x] = meta.view("<u4")
    return nodes, ~codes[leaf].astype(np.int64) // LEAF_STEP, counts[leaf]


def _quantise(words: Words, order: NDArray[np.uint8], nodes: NDArray[np.uint32]) -> None:
    """Write the boxes of nodes: never smaller than they were, when decoded in float32.

    Rounding is monotonic, and what bounds a float32 still does when it has been rounded to one. Origins and cells are
    multiples of 2**-126: no sum is denormal, which a GPU may take for 0.
    """
    lo, hi, used = (np.take_along_axis(part, order[:, None].astype(np.intp), 2) for part in _boxes(words))
    low = np.where(used, lo, np.inf).min(2)
    low = np.where(used.any(2), np.floor(low / _GRID) * _GRID, 0)
    extent = np.where(used, hi - low[..., None], 0).max(2)
    finest = np.frexp(np.abs(low))[1] - _ULP_EXPONENT  # an empty slot's planes are never rounded to the same number
    exponent = np.maximum(np.frexp(extent / 255)[1], np.where(low == 0, _LEAST_EXPONENT, finest))
    exponent = np.maximum(exponent, _LEAST_EXPONENT)[..., None]
    cell, origin = np.ldexp(1.0, exponent), low[..., None]
    below, above = np.floor((lo - origin) / cell), np.ceil((hi - origin) / cell)
    below -= origin + below * cell > lo  # where the difference was rounded to a whole number of cells
    above += origin + above * cell < hi
    planes = np.stack([np.where(used, below, 255), np.where(used, above, 0)], 1).astype(np.uint8)
    fields = COMPRESSED_NODE
    nodes[:, :fields.exponents] = low.astype(np.float32).view(np.uint32)
    scales = np.concatenate([exponent[..., 0], np.zeros((len(nodes), 1))], 1).astype(np.int8)
    nodes[:, fields.exponents] |= scales.view("<u4")[:, 0]
    nodes[:, fields.lo_x:] = planes.reshape(len(nodes), -1).view("<u4")
