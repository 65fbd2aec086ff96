"""Vectors of three registers."""

import numpy as np
from lane_helpers import F, compile_test

from glimt.lanes import (
    LANES,
    cross,
    dot,
    extract,
    f32,
    lane_numbers,
    load,
    normalize,
    pointer,
    scalar3,
    select3,
    splat3,
    store,
    vector3,
)

COUNT = 12


@compile_test
def _put(out, row, v):
    store(out, (3 * row) * LANES, v.x)
    store(out, (3 * row + 1) * LANES, v.y)
    store(out, (3 * row + 2) * LANES, v.z)


@compile_test
def _vectors(words, out):
    a = vector3(load(words, 0), load(words, LANES), load(words, 2 * LANES))
    b = vector3(load(words, 3 * LANES), load(words, 4 * LANES), load(words, 5 * LANES))
    half = lane_numbers() < np.int32(LANES // 2)
    _put(out, 0, a + b)
    _put(out, 1, a - b)
    _put(out, 2, a * b)
    _put(out, 3, a * 3.0)
    _put(out, 4, 2.0 - a)
    _put(out, 5, a * load(words, 0))
    _put(out, 6, cross(a, b))
    _put(out, 7, normalize(a))
    _put(out, 8, select3(half, a, b))
    _put(out, 9, select3(half, f32(1.5), vector3(extract(a.x, 2), extract(a.y, 2), extract(a.z, 2))))
    _put(out, 10, splat3(dot(a, b)))
    _put(out, 11, vector3(1, 2.5, load(words, 0)))


def test_vector_functions_match_numpy():
    words = np.random.default_rng(4).normal(size=6 * LANES).astype(F)
    out = np.empty(COUNT * 3 * LANES, F)
    _vectors(words, out)
    a, b = words.reshape(2, 3, LANES).astype(np.float64)
    half = np.arange(LANES) < LANES // 2
    expected = [a + b, a - b, a * b, 3 * a, 2 - a, a * a[0], np.cross(a, b, axis=0), a / np.linalg.norm(a, axis=0),
                np.where(half, a, b), np.where(half, 1.5, a[:, 2:3]), np.tile((a * b).sum(0), (3, 1)),
                [np.ones(LANES), np.full(LANES, 2.5), a[0]]]
    np.testing.assert_allclose(out.reshape(COUNT, 3, LANES), expected, rtol=1e-6, atol=2e-6)


@compile_test
def _same(words, out):
    _put(out, 0, scalar3(pointer(words), 2))


def test_scalar3_is_the_same_in_all_lanes():
    out = np.empty(3 * LANES, F)
    _same(np.arange(8, dtype=F), out)
    np.testing.assert_array_equal(out.reshape(3, LANES), np.repeat([[2], [3], [4]], LANES, 1))
