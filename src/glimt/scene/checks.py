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
        given = np.asarray(value)
        with np.errstate(over="ignore", invalid="ignore"):  # what does not fit is refused below
            result = np.ascontiguousarray(given, dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise GlimtError(f"{owner}: {field} is not an array of numbers: {error}") from None
    fits = result.ndim == len(shape) and all(w in (None, s) for w, s in zip(shape, result.shape, strict=True))
    if not fits:
        wanted = "(" + ", ".join("n" if s is None else str(s) for s in shape) + ")"
        raise GlimtError(f"{owner}: {field} has shape {result.shape}, expected {wanted}")
    if result.dtype.kind == "f" and not np.isfinite(result).all():
        raise GlimtError(f"{owner}: {field} has values that are not finite")
    if result.dtype.kind == "i" and not np.can_cast(given.dtype, result.dtype) and not np.array_equal(result, given):
        raise GlimtError(f"{owner}: {field} has values that are not whole numbers of {8 * result.itemsize} bits")
    return result


def coordinates(owner: str, field: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float32]:
    """Return `value` as finite float32 coordinates no larger than `LARGEST`."""
    wide = array(owner, field, value, shape, np.float64)
    if wide.size and np.abs(wide).max() > LARGEST:
        raise GlimtError(f"{owner}: {field} has a coordinate beyond {LARGEST:g}; scale the scene down")
    return wide.astype(np.float32)


def vector(owner: str, field: str, value: Any) -> tuple[float, float, float]:
    """Return `value` as three finite floats."""
    x, y, z = _components(owner, field, value, 3)
    return x, y, z


def pair(owner: str, field: str, value: Any) -> tuple[float, float]:
    """Return `value` as two finite floats."""
    x, y = _components(owner, field, value, 2)
    return x, y


def _components(owner: str, field: str, value: Any, count: int) -> list[float]:
    components: list[float] = array(owner, field, value, (count,), np.float64).tolist()
    if max(map(abs, components)) > LARGEST:
        raise GlimtError(f"{owner}: {field} has a component beyond {LARGEST:g}; scale the scene down")
    return components


def direction(owner: str, field: str, value: Any) -> tuple[float, float, float]:
    """Return `value` as three finite floats that are not all zero."""
    result = vector(owner, field, value)
    if not any(result):
        raise GlimtError(f"{owner}: {field} is a zero vector, which points nowhere")
    return result


def color(owner: str, field: str, value: Any) -> tuple[float, float, float]:
    """Return `value`, one number or three, as a linear colour with no negative part."""
    is_number = np.isscalar(value) or getattr(value, "shape", None) == ()
    result = vector(owner, field, (value,) * 3 if is_number else value)
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


def kind(owner: str, field: str, value: Any, *kinds: type) -> None:
    """Refuse a `value` that is none of `kinds`, most often a file's name where its content is wanted."""
    if not isinstance(value, kinds):
        wanted = " or ".join(one.__name__ for one in kinds if one is not type(None))
        raise GlimtError(f"{owner}: {field} is of type {type(value).__name__}, expected {wanted}")
