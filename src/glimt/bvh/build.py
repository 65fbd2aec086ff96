"""Boxes in, tree out."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.bvh import subtrees
from glimt.bvh.subtrees import (
    DEPTH,
    FIRST_CUT,
    HEIGHT,
    LEAF_BASE,
    LEAVES,
    NODE_BASE,
    NODES,
    ROOT,
    START,
    STOP,
    TASK_WORDS,
    build_subtrees,
    lay_out,
    prepare_boxes,
)
from glimt.bvh.wide import RECORD, WIDTH, WideTree
from glimt.layout import LEAF_SIZE, NODE, STACK_SIZE, aligned

_PARALLEL_FROM = 4096  # boxes; below, threads cost more than they give
_MOST_TOP_NODES = 1024


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

    The binary nodes of a range [first, end) of boxes are those from 2 first, below a root that is elsewhere; the nodes
    from 2n are the top of the tree, and its leaves the roots of such ranges. Node 2n - 1 is never used, and empty.
    """

    def __init__(self, lo: NDArray[np.float32], hi: NDArray[np.float32], leaf_size: int,
                 pool: ThreadPoolExecutor | None, helpers: int) -> None:
        self.pool, self.helpers, self.leaf_size, self.count = pool, helpers, leaf_size, len(lo)
        self.top = 2 * self.count
        top_nodes = _MOST_TOP_NODES if self.count > _PARALLEL_FROM else 1
        self.boxes, self.spare = aligned(8 * self.count), aligned(8 * self.count)
        self.binary, self.meta = aligned(RECORD * (self.top + top_nodes)), np.empty((self.top + top_nodes, 2), np.int32)
        self.cuts = np.empty(WIDTH * (self.count + top_nodes), np.int32)
        bounds = np.empty((-(-self.count // subtrees.CHUNK), 8), np.float32)
        self._run(prepare_boxes, lo, hi, self.boxes, bounds.ravel())
        self._set(self.top, bounds.min(0), 0, self.count)
        self._set(self.top - 1, 3e38, 0, 0)

    def _set(self, node: int, box: Any, first: int, count: int) -> None:
        self.binary[RECORD * node:RECORD * node + 8], self.meta[node] = box, (first, count)

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

    def tree(self) -> WideTree:
        """Build the tree."""
        tasks = self._build_binary()
        nodes_before, leaves_before = (np.cumsum(tasks[:, column]) - tasks[:, column] for column in (NODES, LEAVES))
        tasks[:, NODE_BASE], tasks[:, LEAF_BASE] = nodes_before, leaves_before
        depth = self._join_to_top(tasks)
        if (WIDTH - 1) * depth + 1 > STACK_SIZE:
            raise AssertionError(f"a tree of depth {depth} does not fit the traversal's stack")
        nodes = aligned(NODE.words * int(tasks[:, NODES].sum()))
        leaf_prims = np.empty((int(tasks[:, LEAVES].sum()), int(LEAF_SIZE)), np.int32)
        self._run(lay_out, tasks, self.boxes, self.binary, self.meta.ravel(), self.cuts, nodes, leaf_prims)
        return WideTree(nodes, leaf_prims, depth)

    def _build_binary(self) -> NDArray[np.int64]:
        """Build and collapse the binary tree; return the top as a task, then those of the subtrees, from left to right.

        The top has no nodes when all is one subtree.
        """
        roots, depths, used = self._split_top()
        first, counts = self.meta[roots].astype(np.int64).T
        real = (counts > self.leaf_size) | (used == 1)
        order = np.argsort(first[real], kind="stable")
        tasks = np.zeros((len(order) + 1, TASK_WORDS), np.int64)
        for column, values in ((ROOT, roots), (DEPTH, depths), (START, 2 * first), (FIRST_CUT, WIDTH * first)):
            tasks[1:, column] = values[real][order]
        largest_first = 1 + np.argsort(-counts[real][order], kind="stable")
        built = tasks[largest_first]
        self._build(built, subtrees.BUILD)
        tasks[largest_first] = built
        if used > 1:
            tasks[0, [ROOT, START, STOP, FIRST_CUT]] = self.top, self.top, self.top + used, WIDTH * self.count
            self._build(tasks[:1], subtrees.COLLAPSE)
        return tasks

    def _split_top(self) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
        """Split what is too large for one task; return nodes and depths of what is left, and the top's node count."""
        task_size = max(self.count // 32, 1024) if self.count > _PARALLEL_FROM else self.count
        opened, used, depth, roots, depths = np.array([self.top]), 1, 0, [], []
        while len(opened):
            fits = used + 2 * len(opened) <= _MOST_TOP_NODES
            large = self.meta[opened, 1] > (task_size if fits else self.count)
            roots.append(opened[~large])
            depths += [depth] * len(roots[-1])
            tasks = np.zeros((int(large.sum()), TASK_WORDS), np.int64)
            tasks[:, ROOT], tasks[:, DEPTH] = opened[large], depth
            tasks[:, START] = self.top + used + 2 * np.arange(len(tasks))
            if len(tasks):
                self._build(tasks, subtrees.SPLIT_ONCE)
            opened = self.top + used + np.arange(2 * len(tasks))
            used, depth = used + 2 * len(tasks), depth + 1
        return np.concatenate(roots), np.array(depths), used

    def _join_to_top(self, tasks: NDArray[np.int64]) -> int:
        """Tell the top where the nodes of the subtrees begin; return the depth of the whole tree."""
        if not tasks[0, NODES]:
            return int(tasks[1, HEIGHT])
        roots = tasks[1:, ROOT]
        above = -1 - self.meta[roots, 1]
        self.meta[roots, 0] = tasks[1:, NODE_BASE]
        return int((above + tasks[1:, HEIGHT]).max(initial=tasks[0, HEIGHT]))
