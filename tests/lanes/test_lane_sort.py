"""Lanes in another order."""

import itertools

import numpy as np
from lane_helpers import F, compile_test

from glimt.lanes import (
    LANES,
    compress8,
    load8_int,
    load_int,
    numbers8,
    numbers_in_fours,
    pack8,
    prefetch,
    shuffle,
    sort8,
    store,
    store8,
    unpack8,
)


@compile_test
def _sort(keys, out):
    for i in range(0, len(keys), 8):
        store8(out, i, sort8(load8_int(keys, i)))


@compile_test
def _permute(values, index, out):
    for i in range(0, len(values), 8):
        store8(out, i, shuffle(load8_int(values, i), load8_int(index, i)))
    store8(out, len(values), shuffle(load8_int(values, 0), -numbers8()))


def test_eight_integers_are_sorted():
    """A network that sorts every sequence of zeros and ones sorts everything (Knuth, volume 3, 5.3.4)."""
    switches = np.array(list(itertools.product((0, 1), repeat=8)), np.int32)
    random = np.random.default_rng(1)
    anything = random.integers(-2**31, 2**31, (500, 8)).astype(np.int32)
    repeated = random.integers(-2, 3, (500, 8)).astype(np.int32)
    extremes = np.array([[-1, 2**31 - 1, 0, -2**31, 2**31 - 1, -1, -2**31, 1]], np.int32)
    keys = np.concatenate([switches, anything, repeated, extremes])
    out = np.empty(keys.size, np.int32)
    _sort(keys.reshape(-1), out)
    np.testing.assert_array_equal(out.reshape(-1, 8), -np.sort(-keys.astype(np.int64), 1))


def test_eight_lanes_are_permuted():
    random = np.random.default_rng(2)
    values, index = random.integers(-2**31, 2**31, (2, 500, 8)).astype(np.int32)
    out = np.empty(values.size + 8, np.int32)
    _permute(values.reshape(-1), index.reshape(-1), out)
    np.testing.assert_array_equal(out[:-8].reshape(-1, 8), np.take_along_axis(values, index & 7, 1))
    np.testing.assert_array_equal(out[-8:], values[0, [0, 7, 6, 5, 4, 3, 2, 1]])


@compile_test
def _pack(values, words, out):
    for i in range(len(words)):
        words[i] = pack8(load8_int(values, 8 * i))
        store8(out, 8 * i, unpack8(words[i]))


def test_eight_numbers_are_packed():
    values = np.random.default_rng(4).integers(-2**31, 2**31, (500, 8)).astype(np.int32)
    words, out = np.empty(500, np.int32), np.empty((500, 8), np.int32)
    _pack(values.reshape(-1), words, out.reshape(-1))
    np.testing.assert_array_equal(words.view(np.uint32), ((values & 7).astype(np.uint32) << 4 * np.arange(8)).sum(1))
    np.testing.assert_array_equal(out, values & 7)


@compile_test
def _compress(values, out):
    for i in range(0, len(values), 8):
        value = load8_int(values, i)
        store8(out, i, compress8(value, value >= 0))


def test_chosen_lanes_are_put_side_by_side():
    chosen = np.array(list(itertools.product((False, True), repeat=8)))
    values = np.random.default_rng(5).integers(1, 2**31, chosen.shape).astype(np.int32)
    values[~chosen] *= -1
    out = np.empty(values.shape, np.int32)
    _compress(values.reshape(-1), out.reshape(-1))
    for row, result in zip(values, out, strict=True):
        np.testing.assert_array_equal(result[:(row > 0).sum()], row[row > 0])


@compile_test
def _shuffle_all(values, index, out):
    store(out, 0, shuffle(load_int(values, 0), load_int(index, 0)))


def test_all_lanes_are_shuffled():
    random = np.random.default_rng(3)
    values, index = random.integers(-2**31, 2**31, (2, LANES)).astype(np.int32)
    out = np.empty(LANES, np.int32)
    _shuffle_all(values, index, out)
    np.testing.assert_array_equal(out, values[index & (LANES - 1)])


@compile_test
def _in_fours(word, out):
    store(out, 0, numbers_in_fours(np.int32(word)))


def test_numbers_of_the_lowest_bits():
    out = np.empty(LANES, np.int32)
    for word in (0, 1, 0b1010_0110, 0xFFFF, 1 << (LANES - 1), 0b11 << (LANES - 2)):
        numbers = [k for k in range(32) if word >> k & 1][:LANES // 4]
        _in_fours(word, out)
        np.testing.assert_array_equal(out, np.repeat(numbers + [0] * (LANES // 4 - len(numbers)), 4))


@compile_test
def _prefetch(words):
    for k in (0, len(words), 10**12, -10**12):
        prefetch(words, k)
    return len(words)


def test_prefetching_reads_nothing():
    """Past the end, or nowhere at all."""
    assert _prefetch(np.zeros(3, F)) == 3
