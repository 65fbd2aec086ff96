"""What a packet takes for granted: by the signs of edge functions alone a ray is within a triangle's bounds."""

import numpy as np
import pytest

from glimt.engines.cpu.kernels.triangle import edges, within
from glimt.kernel import kernel
from glimt.lanes import LANES, f32, load3, pointer, select, store

COUNT = 1 << 16


@kernel
def _tell(corners, answers):
    """Write three edge functions of each triangle, whether they agree, and whether 0 is within its bounds."""
    n, words, out = corners.shape[1], pointer(corners), pointer(answers)
    for i in range(0, n, LANES):
        a, b, c = load3(words, i, n), load3(words, 3 * n + i, n), load3(words, 6 * n + i, n)
        wa, wb, wc, between = edges(a, b, c)
        store(out, i, wa)
        store(out, n + i, wb)
        store(out, 2 * n + i, wc)
        store(out, 3 * n + i, select(between, f32(1.0), 0.0))
        store(out, 4 * n + i, select(within(a, b, c), f32(1.0), 0.0))


def _spread(random, size):
    return random.uniform(-1, 1, (9, COUNT)) * size


CORNERS = {
    "around the ray": lambda random: _spread(random, 1.0),
    "slivers": lambda random: np.tile(_spread(random, 1.0)[:3], (3, 1)) + _spread(random, 1e-6),
    "far away": lambda random: np.tile(_spread(random, 1e6)[:3], (3, 1)) + _spread(random, 1e-1),
    "on a grid": lambda random: random.integers(-2, 3, (9, COUNT)),
    "of all sizes": lambda random: _spread(random, 1.0) * 2.0 ** random.integers(-70, 60, (9, COUNT)),
    "all sizes, each its own": lambda random: _spread(random, 1.0) * 2.0 ** random.integers(-70, 60, COUNT),
}


@pytest.mark.parametrize("make", CORNERS.values(), ids=CORNERS)
def test_signs_are_never_wrong(make):
    corners = np.ascontiguousarray(make(np.random.default_rng(11)), np.float32)
    answers = np.empty((5, COUNT), np.float32)
    _tell(corners, answers)
    functions, between, inside_bounds = answers[:3], answers[3] > 0, answers[4] > 0
    sure = between & (functions != 0).all(0)
    assert inside_bounds[sure].all()
    np.testing.assert_array_equal(between, ~((functions < 0).any(0) & (functions > 0).any(0)))
    a, b, c = corners.astype(np.float64).reshape(3, 3, COUNT)  # products of two float32 are exact
    exact = np.array([p[0] * q[1] - p[1] * q[0] for p, q in ((c, b), (a, c), (b, a))])
    assert (np.sign(functions) * np.sign(exact) >= 0).all()
    assert (exact[functions != 0] != 0).all()


def test_only_zeros_can_be_outside():
    """A triangle so far from the ray that its edge functions round to 0 is not met."""
    corners = np.zeros((9, LANES), np.float32)
    corners[:] = np.float32(1e-30)  # products vanish
    answers = np.empty((5, LANES), np.float32)
    _tell(corners, answers)
    assert (answers[:3] == 0).all()
    assert (answers[3] > 0).all()
    assert not (answers[4] > 0).any()
