"""The ring of frame times and its percentiles, against a list and NumPy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from glimt.viewer.overlay.frame_times import FrameTimes

seconds = st.lists(st.floats(0, 5), max_size=60)


def _ring(times, kept=240):
    ring = FrameTimes(kept)
    for one in times:
        ring.add(one)
    return ring


@given(seconds, st.integers(1, 20))
def test_the_last_times_are_kept_in_order(times, kept):
    ring = _ring(times, kept)
    assert ring.array().tolist() == times[-kept:]
    assert len(ring) == min(len(times), kept)
    assert ring.last == (times[-1] if times else 0)


@given(seconds, st.floats(0, 100))
def test_percentiles_are_those_of_numpy_over_the_last_two_seconds(times, q):
    recent, total = [], 0.0
    for one in reversed(times):
        total += one
        if recent and total > 2:
            break
        recent.append(one)
    expected = np.percentile(recent, q) if recent else 0
    np.testing.assert_allclose(_ring(times).percentile(q), expected, rtol=1e-12, atol=1e-15)


def test_percentiles_of_fast_frames_are_those_of_120_frames():
    ring = _ring([0.009] * 100 + [0.001] * 120)
    assert ring.percentile(100) == 0.001
    ring.add(0.004)
    assert ring.percentile(100) == 0.004


def test_a_cleared_ring_has_forgotten_all():
    ring = _ring([0.25, 0.5])
    assert ring.percentile(50) == 0.375
    ring.clear()
    assert (len(ring), ring.last, ring.percentile(50), ring.array().tolist()) == (0, 0, 0, [])
    ring.add(0.125)
    assert (ring.percentile(50), ring.array().tolist()) == (0.125, [0.125])


def test_the_array_is_a_copy():
    ring = _ring([0.25])
    ring.array()[:] = 9
    assert ring.last == 0.25
