"""Refitted trees: the same shape, boxes as tight as those of a build, everything within what is above it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glimt import bvh
from glimt.errors import GlimtError
from glimt.layout import LEAF_STEP, NODE

WIDTH = 8


def boxes(count, seed, size=0.05):
    random = np.random.default_rng(seed)
    centers, half = random.normal(size=(count, 3)), size * random.random((count, 3))
    return (centers - half).astype(np.float32), (centers + half).astype(np.float32)


def bounds_below(tree, lo, hi):
    """Return the exact bounds of what is below each child, (nodes, 8) twice three, children before parents."""
    codes = tree.nodes.reshape(-1, NODE.words).view(np.int32)[:, NODE.child:NODE.child + WIDTH]
    used = tree.nodes.reshape(-1, NODE.words)[:, :WIDTH] < 1e38
    low, high = np.full((*codes.shape, 3), np.float32(3e38)), np.full((*codes.shape, 3), np.float32(-3e38))
    for node in range(len(codes) - 1, -1, -1):
        for k in np.nonzero(used[node])[0]:
            code = int(codes[node, k])
            if code >= 0:
                assert code > node
                low[node, k], high[node, k] = low[code].min(0), high[code].max(0)
            else:
                prims = tree.leaf_prims[~code // LEAF_STEP, :~code % LEAF_STEP]
                low[node, k], high[node, k] = lo[prims].min(0), hi[prims].max(0)
    return low, high


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.integers(1, 300), st.integers(0, 1000), st.sampled_from([0.0, 1e-12, 1.0, 1e12]), st.sampled_from([1, 2, 4]))
def test_every_box_is_the_bounds_of_what_is_below(count, seed, size, leaf_size):
    tree = bvh.build(*boxes(count, seed), leaf_size=leaf_size)
    lo, hi = boxes(count, seed + 1, size)
    refitted = bvh.refit(tree, lo, hi)
    sides = refitted.nodes.reshape(-1, NODE.words)[:, :NODE.child].reshape(-1, 2, 3, WIDTH)
    low, high = bounds_below(refitted, lo, hi)
    np.testing.assert_array_equal(sides[:, 0].transpose(0, 2, 1), low)
    np.testing.assert_array_equal(sides[:, 1].transpose(0, 2, 1), high)
    assert refitted.depth == tree.depth
    codes = [nodes.view(np.int32).reshape(-1, NODE.words)[:, NODE.child:NODE.order]
             for nodes in (refitted.nodes, tree.nodes)]
    np.testing.assert_array_equal(*codes)


@pytest.mark.parametrize("count", [0, 1, 4, 5, 100, 6000])
@pytest.mark.parametrize("leaf_size", [1, 4])
def test_unchanged_boxes_give_the_same_tree_to_the_bit(count, leaf_size):
    lo, hi = boxes(count, 7)
    lo[::3, 0], hi[::3, 0] = -0.0, 0.0  # zeros of both signs
    lo[1::3, 0], hi[1::3, 0] = 0.0, -0.0
    tree = bvh.build(lo, hi, leaf_size=leaf_size)
    before = tree.nodes.tobytes()
    moved = bvh.refit(tree, lo + 1, hi + 1)
    assert tree.nodes.tobytes() == before
    assert bvh.refit(tree, lo, hi).nodes.tobytes() == before
    assert bvh.refit(moved, lo, hi).nodes.tobytes() == before
    assert moved.nodes.ctypes.data % 64 == 0


@pytest.mark.parametrize("count", [9, 11])
def test_another_number_of_boxes_is_refused(count):
    tree = bvh.build(*boxes(10, 0))
    with pytest.raises(GlimtError, match=r"10 primitives.*build a new tree"):
        bvh.refit(tree, *boxes(count, 0))
