"""Elementary functions on lanes: the errors their docstrings state hold over the whole domain."""

import re

import numpy as np
import pytest
from lane_helpers import F, lanewise

from glimt.lanes import arccos, arctan2, exp2, log2, power
from glimt.lanes import math as lane_math

RNG = np.random.default_rng(2)


def _stated(function):
    """Return the largest error that a docstring states."""
    text = function.py_func.__doc__
    assert text.count("error") == 1
    return float(re.search(r"error\S* < (\S+?)[;,.]?(?:\s|$)", text.split(";", 1)[1])[1])


def _worst(got, expected):
    return np.abs(got.astype(np.float64) - expected).max()


def test_log2():
    exponents = np.repeat(np.arange(-126, 128), 4000)
    x = np.concatenate([np.ldexp(1 + RNG.random(exponents.size), exponents), 1 + 1e-5 * RNG.normal(size=10000),
                        RNG.uniform(0.5, 2, 500000), [2.0**-126, 1, 2, np.finfo(F).max]]).astype(F)
    expected = np.log2(x.astype(np.float64))
    got = lanewise(lambda a: log2(a))(x)
    assert (np.abs(got - expected) / np.maximum(np.abs(expected), 1)).max() < _stated(log2)
    np.testing.assert_array_equal(lanewise(lambda a: log2(a))(F(2.0)**np.arange(-126, 128, dtype=F)),
                                  np.arange(-126, 128))


def test_exp2():
    x = np.concatenate([RNG.uniform(-126, 126, 1000000), RNG.uniform(-1, 1, 200000),
                        np.arange(-126, 127), np.arange(-126, 126) + 0.5]).astype(F)
    expected = np.exp2(x.astype(np.float64))
    got = lanewise(lambda a: exp2(a))(x)
    assert (np.abs(got - expected) / expected).max() < _stated(exp2)
    whole = np.arange(-126, 127, dtype=F)
    np.testing.assert_array_equal(lanewise(lambda a: exp2(a))(whole), F(2)**whole)
    np.testing.assert_array_equal(lanewise(lambda a: exp2(a))(F([-1e9, -127, 127, 1e9, -np.inf, np.inf])),
                                  F(2)**F([-126, -126, 126, 126, -126, 126]))


@pytest.mark.parametrize("largest", [1, 10, 100, 1000])
def test_power(largest):
    x = np.concatenate([RNG.random(300000), 1 - 10**RNG.uniform(-7, -1, 300000), 10**RNG.uniform(-6, 6, 100000)])
    x = x.astype(F)
    y = (largest * RNG.uniform(-1, 1, len(x))).astype(F)
    y[::3] = largest
    exponent = y * np.log2(x.astype(np.float64))
    inside = (x > 0) & (np.abs(exponent) < 125.9)
    x, y, expected = x[inside], y[inside], np.exp2(exponent[inside])
    assert len(x) > 10000
    relative = np.abs(lanewise(lambda a, b: power(a, b))(x, y) - expected) / expected
    assert (relative / (1 + np.abs(exponent[inside]))).max() < _stated(power)


def test_power_of_special_exponents():
    x = np.linspace(1e-6, 1, 100).astype(F)
    np.testing.assert_array_equal(lanewise(lambda a: power(a, 0.0))(x), 1)
    np.testing.assert_array_equal(lanewise(lambda a: power(a, 1e6))(np.ones(3, F)), 1)
    assert lanewise(lambda a: power(a, 1e6))(F([0.5]))[0] <= 2.0**-126


def test_arctan2():
    angle = np.concatenate([RNG.uniform(-np.pi, np.pi, 1000000), np.arange(-8, 9) * np.pi / 8])
    radius = 10**RNG.uniform(-18, 18, angle.size)
    y, x = (radius * np.sin(angle)).astype(F), (radius * np.cos(angle)).astype(F)
    got = lanewise(lambda a, b: arctan2(a, b))(y, x)
    assert _worst(got, np.arctan2(y.astype(np.float64), x.astype(np.float64))) < _stated(arctan2)
    exact = lanewise(lambda a, b: arctan2(a, b))(F([0, 0, 1, -1, 0]), F([0, 1, 0, 0, -1]))
    np.testing.assert_array_equal(exact, F([0, 0, np.pi / 2, -np.pi / 2, np.pi]))


def test_arccos():
    x = np.concatenate([RNG.uniform(-1, 1, 1000000), 1 - 10**RNG.uniform(-7, 0, 100000),
                        -1 + 10**RNG.uniform(-7, 0, 100000), [-1, 0, 1]]).astype(F)
    got = lanewise(lambda a: arccos(a))(x)
    assert _worst(got, np.arccos(x.astype(np.float64))) < _stated(arccos)
    beyond = lanewise(lambda a: arccos(a))(F([1.0000002, -1.0000002]))
    np.testing.assert_allclose(beyond, [0, np.pi], atol=1e-6)


def test_every_function_states_its_error():
    functions = [value for value in vars(lane_math).values() if getattr(value, "__module__", "") == lane_math.__name__]
    assert {function.__name__ for function in functions} == {"log2", "exp2", "power", "arctan2", "arccos"}
    assert all("error" in function.py_func.__doc__ for function in functions)
