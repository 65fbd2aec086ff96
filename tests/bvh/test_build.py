"""Trees over boxes: complete, tight enough, shallow enough, the same for any number of threads."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glimt import bvh
from glimt.layout import LEAF_STEP, NODE, STACK_SIZE

WIDTH = 8


def boxes(count, seed=0, size=0.02):
    centers = np.random.default_rng(seed).random((count, 3))
    return (centers - size).astype(np.float32), (centers + size).astype(np.float32)


def check(tree, lo, hi):
    """Walk the tree: every primitive once, within every box above it, and no deeper than it says."""
    nodes = tree.nodes.reshape(-1, NODE.words)
    codes = nodes.view(np.int32)[:, NODE.child:NODE.child + WIDTH]
    seen, deepest = [], 0
    open_nodes = [(0, 1, np.full(3, -np.inf), np.full(3, np.inf))]
    while open_nodes:
        node, depth, above_lo, above_hi = open_nodes.pop()
        deepest = max(deepest, depth)
        sides = nodes[node, :NODE.child].reshape(2, 3, WIDTH)
        for k in range(WIDTH):
            child_lo, child_hi = sides[0, :, k], sides[1, :, k]
            if child_lo[0] > child_hi[0]:
                continue
            assert (child_lo >= above_lo).all()
            assert (child_hi <= above_hi).all()
            code = codes[node, k]
            if code >= 0:
                open_nodes.append((code, depth + 1, child_lo, child_hi))
                continue
            block, count = ~code // LEAF_STEP, ~code % LEAF_STEP
            prims = tree.leaf_prims[block]
            assert (prims[:count] >= 0).all()
            assert (prims[count:] == -1).all()
            assert (lo[prims[:count]] >= child_lo).all()
            assert (hi[prims[:count]] <= child_hi).all()
            seen += prims[:count].tolist()
    assert sorted(seen) == list(range(len(lo)))
    assert deepest == tree.depth
    assert (WIDTH - 1) * deepest + 1 <= STACK_SIZE


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 5, 8, 9, 33, 1000, 5000, 100_000])
@pytest.mark.parametrize("leaf_size", [1, 4])
def test_trees_of_all_sizes_are_complete(count, leaf_size):
    lo, hi = boxes(count)
    tree = bvh.build(lo, hi, leaf_size=leaf_size)
    check(tree, lo, hi)
    assert ((tree.leaf_prims >= 0).sum(1) <= leaf_size).all()


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.integers(1, 200), st.integers(0, 1000), st.sampled_from([0.0, 1e-12, 1e-3, 1.0, 1e9]),
       st.sampled_from([1e-6, 1.0, 1e12]))
def test_trees_of_any_boxes_are_complete(count, seed, size, scale):
    random = np.random.default_rng(seed)
    centers = random.normal(size=(count, 3)) * scale
    centers[random.random(count) < 0.3] = centers[0]  # coincident ones
    half = size * random.random((count, 3)) * scale
    lo, hi = (centers - half).astype(np.float32), (centers + half).astype(np.float32)
    check(bvh.build(lo, hi), lo, hi)


ADVERSARIES = {
    "all the same": np.zeros((20_000, 3)),
    "halving": np.repeat(2.0 ** -np.arange(120)[:, None] * np.ones(3), 50, 0),
    "doubling on one axis": np.repeat(2.0 ** np.arange(40)[:, None] * [1, 0, 0], 200, 0),
    "a line": np.arange(20_000)[:, None] * [1e-3, 0, 0],
    "onions": np.zeros((300, 3)) + 2.0 ** -np.arange(300)[:, None] * [1, 1e-3, 1e-6],
    "two heaps": np.repeat([[0.0, 0, 0], [1e6, 0, 0]], 5000, 0),
    "one far away": np.concatenate([np.random.default_rng(0).random((9999, 3)) * 1e-6, [[1e14, 0, 0]]]),
}


@pytest.mark.parametrize("name", ADVERSARIES)
def test_adversaries_stay_shallow(name):
    centers = ADVERSARIES[name].astype(np.float32)
    tree = bvh.build(centers, centers, threads=2)
    check(tree, centers, centers)


def test_long_thin_boxes_stay_shallow():
    """Sorted slivers that overlap nearly all of each other, each a little longer than the one before."""
    ends = np.linspace(1, 2, 20_000)[:, None] * [1, 1e-6, 1e-6]
    check(bvh.build(-ends, ends), (-ends).astype(np.float32), ends.astype(np.float32))


@pytest.mark.parametrize("count", [100, 4097, 50_000])
def test_threads_do_not_change_the_tree(count):
    lo, hi = boxes(count, size=0.001)
    one, two, three = (bvh.build(lo, hi, threads=threads) for threads in (1, 2, 3))
    for other in (two, three):
        assert other.nodes.tobytes() == one.nodes.tobytes()
        assert other.leaf_prims.tobytes() == one.leaf_prims.tobytes()


def grown(count):
    """Boxes of which most are small and some span much of the scene, so that few splits are balanced."""
    lo, hi = boxes(count, size=0.001)
    hi[::97] += np.float32(0.5)
    return lo, hi


@pytest.mark.parametrize("seed", range(3))
def test_no_inner_child_would_fit_into_its_parent(seed):
    """Wide nodes are chosen so that their areas add up to the least: joining two that fit into one would save one."""
    tree = bvh.build(*grown(2000 + seed))
    codes = tree.nodes.reshape(-1, NODE.words).view(np.int32)[:, NODE.child:NODE.child + WIDTH]
    used = tree.nodes.reshape(-1, NODE.words)[:, :WIDTH] < 1e38
    children = used.sum(1)
    for node, k in zip(*np.nonzero(used & (codes >= 0)), strict=True):
        assert children[node] - 1 + children[codes[node, k]] > WIDTH


def test_nodes_start_on_a_cache_line():
    lo, hi = boxes(100)
    assert bvh.build(lo, hi).nodes.ctypes.data % 64 == 0


def expected_cost(tree, node=0, lo=None, hi=None):
    """Return the visits of nodes and tests of primitives that a ray through the box above a node brings about."""
    sides = tree.nodes.reshape(-1, NODE.words)[node, :NODE.child].reshape(2, 3, WIDTH).astype(np.float64)
    used = [k for k in range(WIDTH) if sides[0, 0, k] <= sides[1, 0, k]]
    if lo is None:
        lo, hi = sides[0][:, used].min(1), sides[1][:, used].max(1)
    cost = 1.0
    for k in used:
        code = int(tree.nodes.view(np.int32)[node * NODE.words + NODE.child + k])
        below = expected_cost(tree, code, sides[0, :, k], sides[1, :, k]) if code >= 0 else ~code % LEAF_STEP
        cost += half_area(sides[1, :, k] - sides[0, :, k]) / half_area(hi - lo) * below
    return cost


def half_area(extent):
    return extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0]


def test_stats_agree_with_a_recount():
    lo, hi = boxes(3000)
    tree = bvh.build(lo, hi)
    stats = bvh.tree_stats(tree)
    codes = tree.nodes.reshape(-1, NODE.words).view(np.int32)[:, NODE.child:NODE.child + WIDTH]
    used = tree.nodes.reshape(-1, NODE.words)[:, :WIDTH] < 1e38
    assert stats.nodes == len(codes) == 1 + (used & (codes >= 0)).sum()
    assert stats.leaves == (used & (codes < 0)).sum() == len(tree.leaf_prims)
    assert stats.prims_per_leaf == pytest.approx(3000 / stats.leaves)
    assert stats.depth == tree.depth
    assert stats.sah_cost == pytest.approx(expected_cost(tree), rel=1e-6)
    assert stats.memory_bytes == tree.nodes.nbytes + tree.leaf_prims.nbytes


def test_a_split_is_worth_it():
    """Two heaps far apart: a random ray through the root meets one of them at most rarely."""
    centers = np.concatenate([np.random.default_rng(0).random((500, 3)),
                              np.random.default_rng(1).random((500, 3)) + [1000, 0, 0]]).astype(np.float32)
    assert bvh.tree_stats(bvh.build(centers, centers)).sah_cost < 4


def test_stats_of_an_empty_tree():
    none = np.zeros((0, 3), np.float32)
    stats = bvh.tree_stats(bvh.build(none, none))
    assert (stats.leaves, stats.depth, stats.sah_cost) == (0, 1, 1.0)
