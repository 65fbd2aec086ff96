"""Every operator and function on lanes against NumPy, on random and special values."""

import numpy as np
import pytest
from lane_helpers import F, compile_test, lanewise, ulps

from glimt import lanes
from glimt.lanes import (
    LANES,
    absolute,
    all_lanes,
    any_lane,
    as_float,
    as_int,
    bits,
    count_trailing_zeros,
    difference,
    extract,
    f32,
    f32x8,
    floor,
    fma,
    highest,
    i32,
    interleave4,
    join,
    lane_numbers,
    least_number,
    load,
    load8,
    lower_half,
    lowest,
    maximum,
    minimum,
    population_count,
    product,
    select,
    sqrt,
    store,
    store8,
    to_float,
    to_int,
    upper_half,
)

SPECIAL = F([0.0, -0.0, 1, -1, np.inf, -np.inf, np.nan, 1e-45, -1e-39, 2**-126, 3.4e38, -3.4e38, 0.5, -0.5, 1.5, -2.5])
RNG = np.random.default_rng(5)


def _pairs():
    """Return all pairs of special values, and random ones of all sizes; a whole number of registers."""
    x, y = (part.ravel() for part in np.meshgrid(SPECIAL, SPECIAL))
    random = (RNG.normal(size=(2, 768)) * 10.0 ** RNG.uniform(-30, 30, (2, 768))).astype(F)
    random[1, ::9] = random[0, ::9]
    return np.concatenate([x, random[0]]), np.concatenate([y, random[1]])


@compile_test
def _float_operators(x, y, out):
    n = len(x)
    for i in range(0, n, LANES):
        a, b = load(x, i), load(y, i)
        store(out, i, a + b)
        store(out, n + i, a - b)
        store(out, 2 * n + i, a * b)
        store(out, 3 * n + i, a / b)
        store(out, 4 * n + i, minimum(a, b))
        store(out, 5 * n + i, maximum(a, b))
        store(out, 6 * n + i, product(a, b))
        store(out, 7 * n + i, difference(a, b))
        store(out, 8 * n + i, -a)
        store(out, 9 * n + i, absolute(a))
        store(out, 10 * n + i, floor(a))
        store(out, 11 * n + i, sqrt(a))
        store(out, 12 * n + i, 2.0 - a)
        store(out, 13 * n + i, a * np.float32(0.1))
        store(out, 14 * n + i, 1 / a)
        store(out, 15 * n + i, select(a < b, a, 7.0))


def test_float_operators_are_ieee():
    x, y = _pairs()
    out = np.empty((16, len(x)), F)
    _float_operators(x, y, out.reshape(-1))
    with np.errstate(all="ignore"):
        expected = [x + y, x - y, x * y, x / y, np.where(x < y, x, y), np.where(x > y, x, y), x * y, x - y, -x,
                    np.abs(x), np.floor(x), np.sqrt(x), F(2) - x, x * F(0.1), F(1) / x, np.where(x < y, x, F(7))]
    for got, wanted in zip(out, expected, strict=True):
        np.testing.assert_array_equal(got, wanted)
    np.testing.assert_array_equal(np.signbit(out[9]), np.zeros(len(x), bool))


@compile_test
def _comparisons(x, y, out):
    for i in range(0, len(x), LANES):
        a, b = load(x, i), load(y, i)
        lt, le, eq = a < b, a <= b, a == b
        code = select(lt, i32(1), 0) + select(le, i32(2), 0) + select(eq, i32(4), 0) + select(a != b, i32(8), 0)
        code = code + select(a > b, i32(16), 0) + select(a >= b, i32(32), 0)
        store(out, i, code + select(lt & ~eq, i32(64), 0) + select(lt | eq, i32(128), 0) + select(le ^ eq, i32(256), 0))


def test_comparisons_are_ordered():
    """Whatever is compared with NaN is false, `!=` included: idle lanes never pass a test."""
    x, y = _pairs()
    out = np.empty(len(x), np.int32)
    _comparisons(x, y, out)
    number = ~np.isnan(x) & ~np.isnan(y)
    lt, le, eq = x < y, x <= y, x == y
    expected = (lt * 1 + le * 2 + eq * 4 + ((x != y) & number) * 8 + (x > y) * 16 + (x >= y) * 32 + (lt & ~eq) * 64
                + (lt | eq) * 128 + (le ^ eq) * 256)
    np.testing.assert_array_equal(out, expected)


@compile_test
def _int_operators(x, y, out):
    n = len(x)
    for i in range(0, n, LANES):
        a, b = as_int(load(x, i)), as_int(load(y, i))
        store(out, i, a + b)
        store(out, n + i, a - b)
        store(out, 2 * n + i, a * b)
        store(out, 3 * n + i, a & b)
        store(out, 4 * n + i, a | b)
        store(out, 5 * n + i, a ^ b)
        store(out, 6 * n + i, ~a)
        store(out, 7 * n + i, -a)
        store(out, 8 * n + i, a << np.int32(5))
        store(out, 9 * n + i, a >> np.int32(5))
        store(out, 10 * n + i, minimum(a, b))
        store(out, 11 * n + i, maximum(a, b))
        store(out, 12 * n + i, select(a < b, i32(1), 0) + select(a == b, i32(2), 0) + select(a >= b, i32(4), 0))
        store(out, 13 * n + i, a + 3)
        store(out, 14 * n + i, as_int(to_float(a)))


@compile_test
def _least_numbers(x, y, out):
    for i in range(0, len(x), LANES):
        store(out, i, least_number(load(x, i), load(y, i)))


def test_the_least_of_two_numbers():
    x, y = _pairs()
    usable = ~(np.isnan(x) | np.isnan(y) | ((x == 0) & (y == 0)))
    out = np.empty_like(x)
    _least_numbers(x, y, out)
    np.testing.assert_array_equal(out[usable], np.minimum(x, y)[usable])


def test_int_operators_wrap_around():
    special = np.array([0, 1, -1, 2**31 - 1, -2**31, 1023, -12345, 7], np.int32)
    x, y = (part.ravel() for part in np.meshgrid(special, special))
    x, y = (np.concatenate([part, RNG.integers(-2**31, 2**31, 512).astype(np.int32)]) for part in (x, y))
    out = np.empty((15, len(x)), np.int32)
    _int_operators(x.view(F), y.view(F), out.reshape(-1))
    with np.errstate(over="ignore"):
        expected = [x + y, x - y, x * y, x & y, x | y, x ^ y, ~x, -x, x << 5, x >> 5, np.minimum(x, y),
                    np.maximum(x, y), (x < y) * 1 + (x == y) * 2 + (x >= y) * 4, x + np.int32(3),
                    x.astype(F).view(np.int32)]
    for got, wanted in zip(out, expected, strict=True):
        np.testing.assert_array_equal(got, wanted)


def test_conversions():
    values = F([0, -0.9, 0.9, 1.5, -7.99, 2**31 - 128, -2**31, 1e9])
    np.testing.assert_array_equal(lanewise(lambda x: to_float(to_int(x)))(values), np.trunc(values))
    special = F([0.0, -0.0, np.inf, np.nan, 1e-45, 3.0])
    again = lanewise(lambda x: as_float(as_int(x)))(special)
    np.testing.assert_array_equal(again.view(np.int32), special.view(np.int32))


def test_fma_rounds_once_where_the_processor_has_it():
    x = (1 + RNG.random(4096)).astype(F)
    got = lanewise(lambda a, b: fma(a, a, b))(x, -x * x)
    exact = x.astype(np.float64)**2 + (-x * x).astype(np.float64)
    if lanes.ops._HAS_FMA:
        np.testing.assert_array_equal(got, exact.astype(F))
    assert np.abs(got - exact).max() <= 2**-23 * 4


def test_product_and_difference_are_never_contracted():
    """a * b - a * b of the same two numbers is 0, always; a fused multiply-add would leave a rounding error."""
    x, y = RNG.random((2, 4096)).astype(F)
    assert not lanewise(lambda a, b: difference(product(a, b), product(b, a)))(x, y).any()


@pytest.mark.parametrize(("name", "reference"), [("reciprocal", lambda x: 1 / x),
                                                 ("reciprocal_sqrt", lambda x: 1 / np.sqrt(x))])
def test_reciprocals_are_within_2_ulp(name, reference):
    function = getattr(lanes, name)
    exponents = np.repeat(np.arange(-125, 126), 400)
    x = np.ldexp(1 + RNG.random(exponents.size), exponents).astype(F)
    got = lanewise(lambda a: function(a))(x)
    assert ulps(got, reference(x.astype(np.float64))).max() <= 2
    if name == "reciprocal":
        np.testing.assert_array_equal(lanewise(lambda a: function(-a))(x), -got)
    np.testing.assert_array_equal(lanewise(lambda a: function(a))(F([1, 4, 16, 2**-20])),
                                  reference(F([1, 4, 16, 2**-20])))


@compile_test
def _across(x, limit, out):
    for i in range(0, len(x), LANES):
        a = load(x, i)
        below = a < limit
        row = i // LANES
        out[row, 0], out[row, 1], out[row, 2] = bits(below), any_lane(below), all_lanes(below)
        out[row, 3], out[row, 4] = lowest(a), highest(a)
        out[row, 5] = population_count(bits(below))
        out[row, 6] = count_trailing_zeros(bits(below)) if bits(below) != 0 else -1
        out[row, 7] = extract(a, row % LANES)
        out[row, 8] = extract(lane_numbers(), row % LANES)
        out[row, 9] = extract(below, row % LANES)


def test_across_lanes():
    x = RNG.random((64, LANES)).astype(F)
    x[0], x[1], x[2] = 0.0, 1.0, np.where(np.arange(LANES) == LANES - 1, 0, np.inf)
    x[3:6] -= F(5)
    out = np.empty((64, 10))
    _across(x.reshape(-1), F(0.3), out)
    below = x < F(0.3)
    packed = (below * 2**np.arange(LANES)).sum(1)
    first = np.where(below.any(1), below.argmax(1), -1)
    row = np.arange(64)
    expected = [packed, below.any(1), below.all(1), x.min(1), x.max(1), below.sum(1), first, x[row, row % LANES],
                row % LANES, below[row, row % LANES]]
    np.testing.assert_array_equal(out.T, expected)


@compile_test
def _halves(x, out):
    a = load(x, 0)
    store(out, 0, join(upper_half(a), lower_half(a)))
    eight = load8(x, 1)
    store8(out, LANES, eight + f32x8(1.0))
    b = a + 100.0
    c = b + 100.0
    d = c + 100.0
    start = LANES + 8
    store(out, start, interleave4(a, b, c, d, 0))
    store(out, start + LANES, interleave4(a, b, c, d, 1))
    store(out, start + 2 * LANES, interleave4(a, b, c, d, 2))
    store(out, start + 3 * LANES, interleave4(a, b, c, d, 3))


def test_halves_and_interleaving():
    x, out = np.arange(32, dtype=F), np.zeros(LANES * 5 + 8, F)
    _halves(x, out)
    np.testing.assert_array_equal(out[:LANES], np.roll(np.arange(LANES), LANES // 2))
    np.testing.assert_array_equal(out[LANES:LANES + 8], np.arange(2, 10))
    expected = (np.arange(LANES)[:, None] + [0, 100, 200, 300]).ravel()
    np.testing.assert_array_equal(out[LANES + 8:], expected)


def test_scalars_become_lanes():
    np.testing.assert_array_equal(lanewise(lambda x: f32(2) + to_float(i32(3)) + x * 0.0)(F([1, 2])), [5, 5])


def test_every_public_lane_name_resolves():
    assert sorted(lanes.__all__, key=lambda name: (name != "LANES", name != "Vector3", name)) == lanes.__all__
    assert all(hasattr(lanes, name) for name in lanes.__all__)
