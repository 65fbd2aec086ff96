"""What blocks of packets need: lanes side by side, masks from bits, planes of vectors, look-ups, bits of an int64."""

import numpy as np
import pytest
from lane_helpers import F, compile_test

from glimt.lanes import (
    LANES,
    compress_store,
    count_trailing_zeros,
    first_bit,
    from_bits,
    i32,
    load,
    load3,
    load_int,
    pick,
    pick_int,
    pointer,
    population_count,
    scalar_int,
    select,
    stack_longs,
    store,
    store3,
    store_scalar,
    store_scalar_int,
)

RNG = np.random.default_rng(8)
ALL = 2**LANES - 1
CHOICES = sorted({0, ALL, 1, ALL ^ 1, 1 << (LANES - 1), ALL >> 1, 0x5555 & ALL, 0xAAAA & ALL,
                  *RNG.integers(0, ALL + 1, 50).tolist()})
"""Lanes to choose, as bits: none, all, one at either end, all but one, every other, and any."""


def chosen(bits):
    """Return which lanes some bits stand for."""
    return (bits >> np.arange(LANES)) & 1 == 1


@compile_test
def _masks(bits, out):
    store(out, 0, select(from_bits(bits), i32(1), 0))


@pytest.mark.parametrize("above", [0, 1 << LANES, -1 << LANES])
def test_bits_become_a_mask_across_all_lanes(above):
    """Bits beyond the last lane are of no matter."""
    for bits in CHOICES:
        out = np.empty(LANES, np.int32)
        _masks(np.int64(bits | above), out)
        np.testing.assert_array_equal(out, chosen(bits))


@compile_test
def _compress(x, bits, out, at):
    compress_store(out, at, load(x, 0), from_bits(bits))


@compile_test
def _compress_ints(x, bits, out, at):
    compress_store(pointer(out), at, load_int(x, 0), from_bits(bits))


@pytest.mark.parametrize(("compress", "dtype"), [(_compress, np.float32), (_compress_ints, np.int32)])
def test_lanes_are_gathered_and_nothing_is_written_beyond(compress, dtype):
    x = RNG.integers(1, 2**30, LANES).astype(dtype)
    for bits in CHOICES:
        for at in (0, 1, 5):
            out = np.full(3 * LANES, -1, dtype)
            compress(x, np.int64(bits), out, at)
            expected = np.full(3 * LANES, -1, dtype)
            packed = x[chosen(bits)]
            expected[at:at + len(packed)] = packed
            np.testing.assert_array_equal(out, expected)


@compile_test
def _append(x, masks, out):
    """Write the lanes of each register after those of the one before, over what has been read: as mirror rays are."""
    at = 0
    for k in range(len(masks)):
        value = load(x, k * LANES)
        compress_store(out, at, value, from_bits(masks[k]))
        at += population_count(masks[k])
    return at


def test_an_array_is_compressed_in_place():
    for _ in range(20):
        x = RNG.random(4 * LANES).astype(F)
        masks = RNG.choice(CHOICES, 4).astype(np.int64)
        kept = x[np.concatenate([chosen(bits) for bits in masks])]
        assert _append(x, masks, x) == len(kept)
        np.testing.assert_array_equal(x[:len(kept)], kept)


@compile_test
def _planes(words, out, index, stride):
    v = load3(words, index, stride)
    store3(out, index + 1, stride + 2, v + v)


@pytest.mark.parametrize("stride", [LANES, 2 * LANES, 4 * LANES + 1])
def test_vectors_lie_in_planes_across_a_stride(stride):
    words, index = RNG.random(4 * stride + LANES).astype(F), 3
    out = np.full(4 * stride + LANES + 8, -1, F)
    _planes(words, out, index, stride)
    expected = np.full_like(out, -1)
    for axis in range(3):
        target = index + 1 + axis * (stride + 2)
        expected[target:target + LANES] = 2 * words[index + axis * stride:][:LANES]
    np.testing.assert_array_equal(out, expected)


@compile_test
def _pick(words, index, k, bits, out, ints):
    here, at, lanes = pointer(words), load_int(index, 0), from_bits(bits)
    store(out, 0, pick(here, at, lanes))
    store(out, LANES, pick(here, k, lanes))
    store(ints, 0, pick_int(here, at, lanes))
    return pick_int(here, k, lanes)


def test_words_are_looked_up_across_lanes_by_one_index_or_by_many():
    """Indices of lanes that do not ask may be anything."""
    words = RNG.random(100).astype(F)
    for bits in CHOICES:
        index, k = RNG.integers(0, 100, LANES).astype(np.int32), np.int64(RNG.integers(100))
        safe = np.where(chosen(bits), index, 0)
        index[~chosen(bits)] = 2**30
        out, ints = np.empty(2 * LANES, F), np.empty(LANES, np.int32)
        assert _pick(words, index, k, np.int64(bits), out, ints) == words.view(np.int32)[k]
        np.testing.assert_array_equal(out[:LANES], np.where(chosen(bits), words[safe], 0))
        np.testing.assert_array_equal(ints.view(F), out[:LANES])
        assert (out[LANES:] == words[k]).all()


@compile_test
def _store_int(words, value):
    store_scalar_int(words, 1, value)
    store_scalar_int(pointer(words), 2, value + 1)
    return scalar_int(words, 1)


@pytest.mark.parametrize("value", [0, 1, -1, 2**31 - 2, -2**31, 0x7F800001])
def test_integers_keep_their_bits_among_floats(value):
    """Also those that as floats would be signalling NaNs."""
    words = np.zeros(4, F)
    assert _store_int(words, np.int32(value)) == value
    assert words.view(np.int32).tolist() == [0, value, value + 1, 0]


@compile_test
def _longs(values, out):
    longs = stack_longs(64)
    for k in range(len(values)):
        store_scalar(longs, k, values[k])
    for k in range(len(values)):
        out[k] = longs[k]


def test_a_stack_of_longs_holds_64_bits_each():
    values, out = RNG.integers(-2**63, 2**63, 64), np.zeros(64, np.int64)
    values[:4] = [-1, 2**63 - 1, -2**63, 1 << 32]
    _longs(values, out)
    np.testing.assert_array_equal(out, values)


@compile_test
def _count(values, narrow, out):
    for k in range(len(values)):
        out[0, k], out[1, k] = population_count(values[k]), count_trailing_zeros(values[k])
        out[2, k], out[3, k] = population_count(narrow[k]), count_trailing_zeros(narrow[k])


@compile_test
def _first_bits(values, narrow, out):
    for k in range(len(values)):
        out[0, k], out[1, k] = first_bit(values[k]), first_bit(narrow[k])


def test_the_first_bit_of_nothing_is_behind_the_last():
    values = np.array([0, 1, -1, 8, -2**63, 1 << 40], np.int64)
    out = np.empty((2, len(values)), np.int64)
    _first_bits(values, values.astype(np.int32), out)
    assert out.tolist() == [[64, 0, 0, 3, 63, 40], [32, 0, 0, 3, 32, 32]]


def test_bits_are_counted_across_64_and_32_of_them():
    values = np.concatenate([RNG.integers(-2**63, 2**63, 200), np.int64(1) << np.arange(64), [-1, -2**63, -2**32]])
    narrow = values.astype(np.int32)
    narrow[narrow == 0] = 1 << 30
    out = np.empty((4, len(values)), np.int64)
    _count(values, narrow, out)
    np.testing.assert_array_equal(out[0], [(int(v) % 2**64).bit_count() for v in values])
    np.testing.assert_array_equal(out[2], [(int(v) % 2**32).bit_count() for v in narrow])
    lowest = [(int(v) & -int(v)).bit_length() - 1 for v in values]
    np.testing.assert_array_equal(out[1], lowest)
    np.testing.assert_array_equal(out[3], [(int(v) & -int(v)).bit_length() - 1 for v in narrow])
