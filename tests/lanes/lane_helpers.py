"""Running lane code on whole arrays."""

import numba
import numpy as np

from glimt.kernel import inline
from glimt.lanes import LANES, load, store

F = np.float32


def compile_test(function):
    """Compile a test's entry point: as `kernel` does, but without a place in the cache."""
    return numba.njit(error_model="numpy", nogil=True)(function)


def lanewise(function):
    """Return the array version of a function of one or two f32 values that gives f32."""
    body = inline(function)
    if function.__code__.co_argcount == 1:
        def run(x, out):
            for i in range(0, len(x), LANES):
                store(out, i, body(load(x, i)))
    else:
        def run(x, y, out):
            for i in range(0, len(x), LANES):
                store(out, i, body(load(x, i), load(y, i)))
    compiled = compile_test(run)

    def apply(*arrays):
        size = len(arrays[0])
        padded = [np.concatenate([np.asarray(a, F), np.ones(-size % LANES, F)]) for a in arrays]
        out = np.empty(len(padded[0]), F)
        compiled(*padded, out)
        return out[:size]

    return apply


def ulps(got, expected):
    """Return the error of float32 values in units in the last place of float64 expectations."""
    return np.abs(got.astype(np.float64) - expected) / np.spacing(np.abs(expected).astype(F)).astype(np.float64)
