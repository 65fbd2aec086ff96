"""Boxes in, tree out."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.bvh.binned_sah import build_tree, prepare_boxes
from glimt.bvh.wide import WIDTH, WideTree, collapse
from glimt.layout import LEAF_SIZE, NODE, STACK_SIZE

_PARALLEL_FROM = 4096  # boxes; below, threads cost more than they give
_MOST_TASKS = 512


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
    with ThreadPoolExecutor(max(1, threads)) as pool:
        boxes = aligned(8 * count)
        whole = _prepare(pool, lo, hi, boxes)
        bounds, meta = aligned(8 * (4 * count + 2)), np.empty(2 * (4 * count + 2), np.int32)
        _build_binary(pool, threads, leaf_size, boxes, bounds, meta, whole)
    return _widen(count, boxes, bounds, meta)


def _empty_tree() -> WideTree:
    nodes = aligned(NODE.words)
    nodes[:NODE.hi_x], nodes[NODE.hi_x:NODE.child] = 3e38, -3e38
    nodes.view(np.int32)[NODE.child:] = -1
    return WideTree(nodes, np.empty((0, int(LEAF_SIZE)), np.int32), 1)


def _prepare(pool: ThreadPoolExecutor, lo: NDArray[np.float32], hi: NDArray[np.float32],
             boxes: NDArray[np.float32]) -> NDArray[np.float32]:
    """Fill `boxes`; return bounds and centre bounds of all."""
    ends = np.linspace(0, len(lo), 5 if len(lo) > _PARALLEL_FROM else 2).astype(np.int64)
    parts = np.empty((len(ends) - 1, 16), np.float32)
    jobs = [pool.submit(prepare_boxes, lo, hi, boxes, part, first, end)
            for part, first, end in zip(parts, ends[:-1], ends[1:], strict=True)]
    for job in jobs:
        job.result()
    whole: NDArray[np.float32] = parts.min(0)
    return whole


def _build_binary(pool: ThreadPoolExecutor, threads: int, leaf_size: int, boxes: NDArray[np.float32],
                  bounds: NDArray[np.float32], meta: NDArray[np.int32], whole: NDArray[np.float32]) -> None:
    count = len(boxes) // 8
    tasks, task_boxes = np.empty(4 * _MOST_TASKS, np.int64), np.empty(16 * _MOST_TASKS, np.float32)
    task_size = max(count // 32, 1024) if count > _PARALLEL_FROM else 0
    spare, counter = aligned(8 * count), np.array([-1, 0])
    run = partial(build_tree, boxes, spare, bounds, meta, leaf_size, whole, task_size, tasks, task_boxes, counter)
    left = pool.submit(run).result()
    if left:
        largest_first = np.argsort(tasks[1:4 * left:4] - tasks[2:4 * left:4], kind="stable")
        tasks[:4 * left] = tasks[:4 * left].reshape(-1, 4)[largest_first].ravel()
        task_boxes[:16 * left] = task_boxes[:16 * left].reshape(-1, 16)[largest_first].ravel()
        counter[:] = 0, left
        for job in [pool.submit(run) for _ in range(max(1, threads))]:
            job.result()


def _widen(count: int, boxes: NDArray[np.float32], bounds: NDArray[np.float32], meta: NDArray[np.int32]) -> WideTree:
    # A node that is not full has leaves only, two or more: there are fewer than 2/3 as many nodes as leaves.
    nodes = aligned(NODE.words * (2 * count // 3 + WIDTH))
    leaf_prims, sizes = np.empty((count, int(LEAF_SIZE)), np.int32), np.zeros(3, np.int64)
    collapse(bounds, meta, boxes.view(np.int32), 2 * count, nodes, leaf_prims, sizes)
    node_count, block_count, depth = sizes.tolist()
    if (WIDTH - 1) * depth + 1 > STACK_SIZE:
        raise AssertionError(f"a tree of depth {depth} does not fit the traversal's stack")
    used = aligned(NODE.words * node_count)
    used[:] = nodes[:len(used)]
    return WideTree(used, leaf_prims[:block_count].copy(), depth)
