"""Loads, stores, gathers, stacks and atomics."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from lane_helpers import F, compile_test

from glimt.lanes import (
    LANES,
    as_int,
    atomic_add,
    atomic_load,
    f32,
    gather,
    gather_int,
    gather_pairs,
    i32,
    lane_numbers,
    load,
    load4_repeated,
    load8,
    pointer,
    scalar,
    scalar_int,
    select,
    stack_floats,
    stack_ints,
    store,
    store8,
    store_scalar,
    ticks,
    to_float,
)


@compile_test
def _copy(x, out, source, target):
    store(out, target, load(x, source))
    store8(out, target + LANES, load8(x, source + LANES))


def test_load_and_store_at_any_word():
    x = np.arange(64, dtype=F)
    for source in range(5):
        for target in range(5):
            out = np.full(64, -1, F)
            _copy(x, out, source, target)
            np.testing.assert_array_equal(out[target:target + LANES + 8], np.arange(source, source + LANES + 8))
            assert (np.delete(out, np.s_[target:target + LANES + 8]) == -1).all()


@compile_test
def _repeat(x, out, source):
    store(out, 0, load4_repeated(x, source))


def test_four_words_fill_all_lanes():
    out = np.empty(LANES, F)
    _repeat(np.arange(16, dtype=F), out, 3)
    np.testing.assert_array_equal(out, np.tile(np.arange(3, 7), LANES // 4))


@compile_test
def _gather(x, index, limit, out, ints):
    words, at = pointer(x), as_int(load(index, 0))
    chosen = lane_numbers() < limit
    store(out, 0, gather(words, at, chosen))
    store(ints, 0, gather_int(words, at, chosen))
    first, second = gather_pairs(words, at, chosen)
    store(ints, LANES, select(chosen, first, i32(0)))
    store(ints, 2 * LANES, select(chosen, second, i32(0)))


def test_gathers_touch_only_their_lanes():
    x = np.random.default_rng(1).random(100).astype(F)
    for limit in range(LANES + 1):
        index = np.random.default_rng(limit).integers(0, 97, LANES).astype(np.int32)
        index[limit:] = 2**30  # far outside: to read there would crash
        out, ints = np.empty(LANES, F), np.empty(3 * LANES, np.int32)
        _gather(x, index.view(F), np.int32(limit), out, ints)
        chosen = np.arange(LANES) < limit
        safe = np.where(chosen, index, 0)
        np.testing.assert_array_equal(out, np.where(chosen, x[safe], 0))
        np.testing.assert_array_equal(ints.view(F).reshape(3, LANES),
                                      [np.where(chosen, x[safe + k], 0) for k in (0, 0, 1)])


@compile_test
def _words(x, out):
    out[0], out[1] = scalar(x, 1), scalar_int(x, 2)
    out[2] = scalar(pointer(x), 1)
    store_scalar(x, 0, 2.5)


def test_single_words_hold_floats_and_integers():
    x, out = np.zeros(4, F), np.zeros(3)
    x[1], x.view(np.int32)[2] = 0.75, -7
    _words(x, out)
    np.testing.assert_array_equal(out, [0.75, -7, 0.75])
    assert x[0] == 2.5


@compile_test
def _stacks(count):
    floats, ints = stack_floats(64), stack_ints(64)
    total = 0.0
    for k in range(count):
        store_scalar(floats, k, k * 0.5)
        store_scalar(ints, k, k * k)
    for k in range(count):
        total += scalar(floats, k) + scalar_int(ints, k)
    store(floats, 0, to_float(lane_numbers()) + f32(0.5))
    return total + scalar(floats, 1)


def test_stacks_hold_what_is_put_there():
    assert _stacks(64) == sum(k * 0.5 + k * k for k in range(64)) + 1.5


@compile_test
def _draw_tickets(shared, drawn):
    for k in range(len(drawn)):
        drawn[k] = atomic_add(shared, 3, 1)
    return atomic_load(shared, 3)


def test_atomics_hand_out_every_ticket_once():
    shared, drawn = np.zeros(8, np.int64), np.zeros((4, 20000), np.int64)
    _draw_tickets(shared, drawn[0, :0])
    with ThreadPoolExecutor(4) as pool:
        last = list(pool.map(lambda mine: _draw_tickets(shared, mine), drawn))
    assert shared.tolist() == [0, 0, 0, drawn.size, 0, 0, 0, 0]
    assert max(last) == drawn.size
    np.testing.assert_array_equal(np.sort(drawn.ravel()), np.arange(drawn.size))
    assert (np.diff(drawn, axis=1) > 0).all()


@compile_test
def _spin(out, rounds):
    start, word = ticks(), np.int64(1)
    for k in range(rounds):
        word = word * 6364136223846793005 + k
    out[0], out[1] = ticks() - start, word


def test_the_clock_runs_on_with_the_work():
    short, long = (np.zeros(2, np.int64) for _ in range(2))
    for _ in range(3):  # the last of a few, in case one was interrupted
        _spin(short, 1000)
        _spin(long, 1_000_000)
    assert 0 < 20 * short[0] < long[0]
