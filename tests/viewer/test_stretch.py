"""A small picture stretched to a large one, against linear interpolation in float64."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glimt.viewer.stretch import stretch


def reference(small, width, height):
    rows, columns = small.shape[:2]
    y = np.clip((np.arange(height) + 0.5) * rows / height - 0.5, 0, rows - 1)
    x = np.clip((np.arange(width) + 0.5) * columns / width - 0.5, 0, columns - 1)
    top, left = np.minimum(y.astype(int), max(rows - 2, 0)), np.minimum(x.astype(int), max(columns - 2, 0))
    bottom, right = np.minimum(top + 1, rows - 1), np.minimum(left + 1, columns - 1)
    down, across = (y - top)[:, None, None], (x - left)[None, :, None]
    mixed = small[top].astype(float) * (1 - down) + small[bottom] * down
    return mixed[:, left] * (1 - across) + mixed[:, right] * across


@given(st.integers(1, 70), st.integers(1, 40), st.integers(1, 90), st.integers(1, 50), st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_within_rounding_of_linear_interpolation(columns, rows, width, height, seed):
    small = np.random.default_rng(seed).integers(0, 256, (rows, columns, 4), np.uint8)
    large = np.zeros((height, width, 4), np.uint8)
    stretch(small, large)
    # Shares are rounded to 1/256, of steps of up to 255 in each direction, and so is what comes out.
    assert np.abs(large - reference(small, width, height)).max() <= 2


@pytest.mark.parametrize("size", [(1, 1), (16, 3), (33, 17)])
def test_same_size_is_a_copy(size):
    small = np.random.default_rng(1).integers(0, 256, (size[1], size[0], 4), np.uint8)
    large = np.zeros_like(small)
    stretch(small, large)
    assert np.array_equal(small, large)
