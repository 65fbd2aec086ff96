"""Elementary functions on lanes: polynomials, since LLVM would call libm once per lane.

Coefficients are least-squares fits on Chebyshev nodes; the stated errors were measured over the whole domain and are
held by a test.
"""

import numpy as np

from glimt.kernel import inline
from glimt.lanes.ops import absolute, as_float, as_int, floor, fma, maximum, minimum, select, sqrt, to_float, to_int

_F = np.float32
_SQRT_HALF_BITS = np.int32(0x3F3504F3)
_MANTISSA_BITS = np.int32(23)
_LOG2 = tuple(_F(c) for c in (1.44269481, -0.721356056, 0.480937271, -0.360123803, 0.286751749, -0.249746612,
                              0.236569623, -0.146295524))
_EXP2 = tuple(_F(c) for c in (1.0, 0.693147004, 0.240222424, 0.0555073358, 0.00967151299, 0.00132647261))
_ATAN = tuple(_F(c) for c in (0.999996112, -0.333173694, 0.198078214, -0.132333523, 0.0796237315, -0.0336042031,
                              0.00681177264))
_ACOS = tuple(_F(c) for c in (1.5707963, -0.21459850, 0.08897899, -0.05017437, 0.03089188, -0.01708813, 0.00667009,
                              -0.00126249))
_HALF_PI, _PI = _F(np.pi / 2), _F(np.pi)


@inline
def log2(x):
    """Return the binary logarithm of x > 0 (normal numbers); |error| < 2e-7 * max(1, |log2 x|)."""
    i = as_int(x)
    exponent = (i - _SQRT_HALF_BITS) >> _MANTISSA_BITS
    f = as_float(i - (exponent << _MANTISSA_BITS)) - 1.0  # mantissa in [sqrt(1/2), sqrt(2)), minus 1
    c = _LOG2
    p = fma(f, fma(f, fma(f, fma(f, fma(f, fma(f, fma(f, c[7], c[6]), c[5]), c[4]), c[3]), c[2]), c[1]), c[0])
    return fma(f, p, to_float(exponent))


@inline
def exp2(x):
    """Return 2**x for x clamped to [-126, 126]; relative error < 3e-7."""
    x = maximum(minimum(x, 126.0), -126.0)
    whole = floor(x + 0.5)
    f = x - whole
    c = _EXP2
    p = fma(f, fma(f, fma(f, fma(f, fma(f, c[5], c[4]), c[3]), c[2]), c[1]), c[0])
    return as_float(as_int(p) + (to_int(whole) << _MANTISSA_BITS))


@inline
def power(x, y):
    """Return x**y for x > 0; relative error < 4e-7 * (1 + |y * log2 x|)."""
    return exp2(y * log2(x))


@inline
def arctan2(y, x):
    """Return the angle of (x, y) in [-π, π], 0 at the origin; |error| < 1e-6."""
    ax, ay = absolute(x), absolute(y)
    larger = maximum(ax, ay)
    a = minimum(ax, ay) / select(larger > 0.0, larger, 1.0)
    s = a * a
    c = _ATAN
    p = fma(s, fma(s, fma(s, fma(s, fma(s, fma(s, c[6], c[5]), c[4]), c[3]), c[2]), c[1]), c[0]) * a
    p = select(ay > ax, _HALF_PI - p, p)
    p = select(x < 0.0, _PI - p, p)
    return select(y < 0.0, -p, p)


@inline
def arccos(x):
    """Return the arc cosine of x in [-1, 1]; |error| < 1e-6 (after Abramowitz and Stegun 4.4.46, refitted)."""
    a = minimum(absolute(x), 1.0)
    c = _ACOS
    p = fma(a, fma(a, fma(a, fma(a, fma(a, fma(a, fma(a, c[7], c[6]), c[5]), c[4]), c[3]), c[2]), c[1]), c[0])
    p = p * sqrt(1.0 - a)
    return select(x < 0.0, _PI - p, p)
