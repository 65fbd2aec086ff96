"""The order in which rays of an octant meet a node's children."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glimt import bvh
from glimt.layout import NODE, dtype

OCTANTS = np.array([[-1 if octant >> axis & 1 else 1 for axis in range(3)] for octant in range(8)])


def boxes(count, seed, size):
    random = np.random.default_rng(seed)
    centers, half = random.normal(size=(count, 3)), size * random.random((count, 3))
    return (centers - half).astype(np.float32), (centers + half).astype(np.float32)


def orders(nodes):
    """Return the children's numbers as (nodes, octants, 8), the nearest first."""
    return (nodes["order"][..., None] >> 4 * np.arange(7, -1, -1)) & 15


def check(tree):
    nodes = tree.nodes.view(dtype(NODE))
    order = orders(nodes)
    np.testing.assert_array_equal(np.sort(order, 2), np.broadcast_to(np.arange(8), order.shape))
    lo, hi = (np.stack([nodes[f"{side}_{axis}"] for axis in "xyz"], 1).astype(np.float64) for side in ("lo", "hi"))
    used = lo[:, 0] <= hi[:, 0]
    along = np.einsum("oa,nak->nok", OCTANTS, np.where(used[:, None], lo + hi, 0))
    sorted_ = np.take_along_axis(along, order, 2)
    rounding = 1e-6 * np.abs(lo + hi)[np.broadcast_to(used[:, None], lo.shape)].max(initial=0)
    for node, octant in itertools.product(range(len(nodes)), range(8)):
        mine = sorted_[node, octant][used[node][order[node, octant]]]
        assert (np.diff(mine) >= -rounding - 1e-6 * np.abs(mine).max(initial=0)).all()


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.integers(1, 200), st.integers(0, 1000), st.sampled_from([0.0, 0.1, 3.0, 1e12]), st.sampled_from([1, 4]))
def test_children_come_from_front_to_back(count, seed, size, leaf_size):
    check(bvh.build(*boxes(count, seed, size), leaf_size=leaf_size))


def test_boxes_in_a_row():
    """Up or down the row, whatever the other axes do."""
    lo = np.zeros((8, 3), np.float32)
    lo[:, 1] = np.arange(8)
    tree = bvh.build(lo, lo + 0.5, leaf_size=1)
    nodes = tree.nodes.view(dtype(NODE))
    for octant, order in enumerate(orders(nodes)[0]):
        row = nodes["lo_y"][0][order]
        np.testing.assert_array_equal(row, np.arange(8) if OCTANTS[octant, 1] > 0 else np.arange(7, -1, -1))


@pytest.mark.parametrize("turn", [np.array([-1, 1, 1]), np.array([-1, -1, -1])])
def test_a_refitted_tree_has_the_order_of_its_new_boxes(turn):
    lo, hi = boxes(300, 1, 0.1)
    tree = bvh.build(lo, hi)
    ends = (lo * turn).astype(np.float32), (hi * turn).astype(np.float32)
    check(bvh.refit(tree, np.minimum(*ends), np.maximum(*ends)))


def test_threads_make_the_same_order():
    lo, hi = boxes(20_000, 2, 0.01)
    one, two = bvh.build(lo, hi, threads=1), bvh.build(lo, hi, threads=2)
    assert one.nodes.tobytes() == two.nodes.tobytes()
    check(one)
