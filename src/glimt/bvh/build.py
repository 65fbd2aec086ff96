"""Boxes in, tree out."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.bvh import subtrees
from glimt.bvh.subtrees import build_subtrees, lay_out, prepare_boxes
from glimt.bvh.wide import RECORD, WIDTH, WideTree
from glimt.layout import LEAF_SIZE, NODE, STACK_SIZE

_PARALLEL_FROM = 4096  # boxes; below, threads cost more than they give
_MOST_TOP_NODES = 1024


def aligned(words: int, dtype: Any = np.float32) -> NDArray[Any]:
    """Return an uninitialised array of 4-byte words that starts on a cache line."""
    raw = np.empty(words * 4 + 64, np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start:start + words * 4].view(dtype)


def build(lo: NDArray[np.float32], hi: NDArray[np.float32], threads: int = 1,
          leaf_size: int = int(LEAF_SIZE)) -> WideTree:
    """Build a tree over n boxes.

    Parameters
    ----------
    lo, hi : (n, 3) float32
        Finite bounds, lo <= hi, below 1e15 in size.
    threads : int
        Used when there are many boxes; the tree is the same for any number.
    leaf_size : int
        Most primitives in a leaf, 1 to 4; 1 where a primitive is dear to test.

    Returns
    -------
    WideTree
        An empty one, with one node that nothing hits, for no boxes.
    """
    count = len(lo)
    if count == 0:
        return _empty_tree()
    lo, hi = np.ascontiguousarray(lo, np.float32), np.ascontiguousarray(hi, np.float32)
    helpers = threads - 1 if count > _PARALLEL_FROM else 0
    with ThreadPoolExecutor(helpers) if helpers > 0 else nullcontext() as pool:
        return _Builder(lo, hi, leaf_size, pool, helpers).tree()


def _empty_tree() -> WideTree:
    nodes = aligned(NODE.words)
    nodes[:NODE.hi_x], nodes[NODE.hi_x:NODE.child] = 3e38, -3e38
    nodes.view(np.int32)[NODE.child:] = -1
    return WideTree(nodes, np.empty((0, int(LEAF_SIZE)), np.int32), 1)


class _Builder:
    """The arrays that a build needs on its way.

    The binary nodes of a range [first, end) of boxes are those from 2 first, under a root that is elsewhere; the nodes
    from 2n are the top of the tree, whose leaves are the roots of such ranges. Node 2n - 1 is never used, and empty.
    """

    def __init__(self, lo: NDArray[np.float32], hi: NDArray[np.float32], leaf_size: int,
                 pool: ThreadPoolExecutor | None, helpers: int) -> None:
        self.pool, self.helpers, self.leaf_size, self.count = pool, helpers, leaf_size, len(lo)
        self.boxes, self.spare = aligned(8 * self.count), aligned(8 * self.count)
        node_count = 2 * self.count + (_MOST_TOP_NODES if self.count > _PARALLEL_FROM else 1)
        self.binary, self.meta = aligned(RECORD * node_count), np.empty((node_count, 2), np.int32)
        self.cuts = np.empty(WIDTH * (self.count + _MOST_TOP_NODES), np.int32)
        bounds = np.empty((-(-self.count // subtrees.CHUNK), 8), np.float32)
        self._run(prepare_boxes, lo, hi, self.boxes, bounds.ravel())
        root = 2 * self.count
        self.binary[RECORD * root:RECORD * root + 8] = bounds.min(0)
        self.meta[root] = 0, self.count
        self.binary[RECORD * (root - 1):RECORD * (root - 1) + 8] = 3e38
        self.meta[root - 1] = 0

    def _run(self, kernel: Callable[..., None], *arguments: Any) -> None:
        """Run a kernel in all threads at once, this one among them."""
        counter = np.zeros(1, np.int64)
        jobs = [self.pool.submit(kernel, *arguments, counter) for _ in range(self.helpers)] if self.pool else []
        kernel(*arguments, counter)
        for job in jobs:
            job.result()

    def _build(self, tasks: NDArray[np.int64], mode: int) -> None:
        self._run(build_subtrees, self.boxes, self.spare, self.binary, self.meta.ravel(), self.cuts, self.leaf_size,
                  tasks, mode)

    def _grow_top(self) -> tuple[NDArray[np.int64], int]:
        """Split what is too large for one thread; return (node, depth) of what is left, and the number of nodes."""
        top, used = 2 * self.count, 1
        task_size = max(self.count // 32, 1024) if self.count > _PARALLEL_FROM else self.count
        opened, depth, closed = np.array([top]), 0, []
        while True:
            large = self.meta[opened, 1] > (task_size if used + 2 * len(opened) < _MOST_TOP_NODES else self.count)
            closed += [(node, depth) for node in opened[~large].tolist()]
            opened = opened[large]
            if not len(opened):
                return np.array(closed, np.int64), used
            tasks = np.zeros((len(opened), subtrees.TASK_WORDS), np.int64)
            tasks[:, subtrees.ROOT], tasks[:, subtrees.DEPTH] = opened, depth
            tasks[:, subtrees.START] = top + used + 2 * np.arange(len(opened))
            self._build(tasks, subtrees.SPLIT_ONCE)
            opened = top + used + np.arange(2 * len(opened))
            used, depth = used + len(opened), depth + 1

    def tree(self) -> WideTree:
        closed, used = self._grow_top()
        top = 2 * self.count
        counts = self.meta[closed[:, 0], 1]
        if used > 1:
            closed, counts = closed[counts > self.leaf_size], counts[counts > self.leaf_size]
        first = self.meta[closed[:, 0], 0]
        tasks = np.zeros((len(closed) + 1, subtrees.TASK_WORDS), np.int64)
        order = np.argsort(-counts, kind="stable")
        tasks[1:, :2] = closed[order]
        tasks[1:, subtrees.START], tasks[1:, subtrees.FIRST_CUT] = 2 * first[order], WIDTH * first[order]
        self._build(tasks[1:], subtrees.BUILD)
        if used > 1:
            tasks[0, [subtrees.ROOT, subtrees.START, subtrees.STOP, subtrees.FIRST_CUT]] = (
                top, top, top + used, WIDTH * self.count)
            self._build(tasks[:1], subtrees.COLLAPSE)
        place = np.argsort(tasks[:, subtrees.FIRST_CUT] * (np.arange(len(tasks)) > 0), kind="stable")
        for base, size in ((subtrees.NODE_BASE, subtrees.NODES), (subtrees.LEAF_BASE, subtrees.LEAVES)):
            tasks[place, base] = np.cumsum(tasks[place, size]) - tasks[place, size]
        roots = tasks[1:, subtrees.ROOT]
        above = -1 - self.meta[roots, 1] if used > 1 else 0
        if used > 1:
            self.meta[roots, 0] = tasks[1:, subtrees.NODE_BASE]
        depth = int((above + tasks[1:, subtrees.HEIGHT]).max(initial=int(tasks[0, subtrees.HEIGHT])))
        if (WIDTH - 1) * depth + 1 > STACK_SIZE:
            raise AssertionError(f"a tree of depth {depth} does not fit the traversal's stack")
        nodes = aligned(NODE.words * int(tasks[:, subtrees.NODES].sum()))
        leaf_prims = np.empty((int(tasks[:, subtrees.LEAVES].sum()), int(LEAF_SIZE)), np.int32)
        self._run(lay_out, tasks, self.boxes, self.binary, self.meta.ravel(), self.cuts, nodes, leaf_prims)
        return WideTree(nodes, leaf_prims, depth)
