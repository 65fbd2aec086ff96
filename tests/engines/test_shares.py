"""Tiles are handed out each once, to whom they belong as long as there are any."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glimt.engines.cpu.control import new_control, new_counters, tiles_taken
from glimt.engines.cpu.kernels.tile import take_tile
from glimt.kernel import kernel


@kernel
def _take(control, counters, width, height, side, most, places):
    """Take up to `most` tiles; return how many there were."""
    for k in range(most):
        left, top = take_tile(control, counters, width, height, side)
        if top < 0:
            return k
        places[k, 0], places[k, 1] = left, top
    return most


def take(control, counters, size, side, most=10_000):
    """Return the tiles that a thread takes, (n, 2)."""
    places = np.zeros((most, 2), np.int64)
    return places[:_take(control, counters, *size, side, most, places)]


@settings(deadline=None)
@given(st.tuples(st.integers(0, 200), st.integers(0, 200)), st.sampled_from([8, 16, 24]), st.integers(1, 9),
       st.lists(st.tuples(st.integers(0, 8), st.integers(0, 12)), max_size=30))
def test_each_tile_once_whoever_comes(size, side, shares, turns):
    control, counters = new_control(shares), new_counters(shares)
    taken = [take(control, counters[thread % shares], size, side, most) for thread, most in turns]
    taken += [take(control, own, size, side) for own in counters]
    places = np.concatenate(taken)
    across, down = (-(-length // side) for length in size)
    assert sorted(map(tuple, places)) == [(side * x, side * y) for x in range(across) for y in range(down)]
    assert tiles_taken(control).sum() >= across * down


@pytest.mark.parametrize("thread", [0, 1, 2])
def test_a_thread_begins_with_its_own_share(thread):
    control, counters = new_control(3), new_counters(3)
    rows = take(control, counters[thread], (64, 96), 16)[:, 1] // 16
    assert rows[:8].tolist() == [2 * thread] * 4 + [2 * thread + 1] * 4
    assert len(rows) == 24
