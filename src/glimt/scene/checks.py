"""Checks that the constructors of scene objects share: each raises `GlimtError` naming the object and the field."""

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from glimt.errors import GlimtError

LARGEST = 1e15
"""Coordinates beyond this are refused: areas, summed over many triangles, would leave float32."""


def array(owner: str, field: str, value: Any, shape: tuple[int | None, ...], dtype: DTypeLike) -> NDArray[Any]:
    """Return `value` as a contiguous array of `shape` (None: any length), or say which field of what is wrong."""
    try:
        result = np.ascontiguousarray(value, dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise GlimtError(f"{owner}: {field} is not an array of numbers: {error}") from None
    fits = result.ndim == len(shape) and all(w in (None, s) for w, s in zip(shape, result.shape, strict=True))
    if not fits:
        wanted = "(" + ", ".join("n" if s is None else str(s) for s in shape) + ")"
        raise GlimtError(f"{owner}: {field} has shape {result.shape}, expected {wanted}")
    if result.dtype.kind == "f" and not np.isfinite(result).all():
        raise GlimtError(f"{owner}: {field} has values that are not finite")
    return result


def coordinates(owner: str, field: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float32]:
    """Return `value` as finite float32 coordinates no larger than `LARGEST`."""
    wide = array(owner, field, value, shape, np.float64)
    if wide.size and np.abs(wide).max() > LARGEST:
        raise GlimtError(f"{owner}: {field} has a coordinate beyond {LARGEST:g}; scale the scene down")
    return wide.astype(np.float32)


def vector(owner: str, field: str, value: Any) -> tuple[float, float, float]:
    """Return `value` as three finite floats."""
    x, y, z = array(owner, field, value, (3,), np.float64).tolist()
    if max(abs(x), abs(y), abs(z)) > LARGEST:
        raise GlimtError(f"{owner}: {field} has a component beyond {LARGEST:g}; scale the scene down")
    return x, y, z


def direction(owner: str, field: str, value: Any) -> tuple[float, float, float]:
    """Return `value` as three finite floats that are not all zero."""
    result = vector(owner, field, value)
    if not any(result):
        raise GlimtError(f"{owner}: {field} is a zero vector, which points nowhere")
    return result


def color(owner: str, field: str, value: Any) -> tuple[float, float, float]:
    """Return `value`, one number or three, as a linear colour with no negative part."""
    result = vector(owner, field, np.broadcast_to(np.asarray(value), 3) if np.ndim(value) == 0 else value)
    if min(result) < 0:
        raise GlimtError(f"{owner}: {field} has a negative part: {result}")
    return result


def number(owner: str, field: str, value: Any, lo: float, hi: float) -> float:
    """Return `value` as a float within [lo, hi]."""
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise GlimtError(f"{owner}: {field} is not a number within reach: {value!r:.60}") from None
    if not lo <= result <= hi:
        raise GlimtError(f"{owner}: {field} is {result:g}, expected {lo:g} to {hi:g}")
    return result
