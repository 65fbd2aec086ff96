"""Affine transforms as (3, 4) float64 matrices, and vectors on (..., 3) batches.

Column vectors: a point p goes to ``matrix[:, :3] @ p + matrix[:, 3]``. Right-handed, metres, radians unless a name
ends in ``_deg``.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = Sequence[float] | NDArray[np.floating]
Array = NDArray[np.float64]


def identity() -> Array:
    """Return the (3, 4) transform that changes nothing."""
    return np.eye(3, 4)


def translation(offset: Vector) -> Array:
    """Return the (3, 4) transform that moves points by `offset` (3,)."""
    matrix = identity()
    matrix[:, 3] = offset
    return matrix


def scaling(factors: float | Vector) -> Array:
    """Return the (3, 4) transform that scales by one factor or by one per axis; negative ones mirror."""
    matrix = identity()
    matrix[:, :3] = np.diag(np.broadcast_to(np.asarray(factors, np.float64), 3))
    return matrix


def rotation(axis: Vector, angle_deg: float) -> Array:
    """Return the (3, 4) transform that turns by `angle_deg` around `axis` (3,), right-handed (Rodrigues' formula)."""
    x, y, z = normalize(np.asarray(axis, np.float64))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(angle_deg)
    matrix = identity()
    matrix[:, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def compose(*matrices: Array) -> Array:
    """Return the product of (3, 4) transforms: the last one is applied to a point first."""
    result = identity()
    for matrix in matrices:
        linear = result[:, :3] @ matrix[:, :3]
        result = np.column_stack([linear, result[:, :3] @ matrix[:, 3] + result[:, 3]])
    return result


def inverse(matrix: Array) -> Array:
    """Return the inverse of (..., 3, 4) transforms; raises `numpy.linalg.LinAlgError` where one is singular."""
    linear = np.linalg.inv(matrix[..., :3])
    return np.concatenate([linear, -linear @ matrix[..., 3:]], -1)


def transform_points(matrix: Array, points: ArrayLike) -> Array:
    """Apply a (3, 4) transform to (..., 3) points."""
    return np.asarray(points, np.float64) @ matrix[:, :3].T + matrix[:, 3]


def transform_vectors(matrix: Array, vectors: ArrayLike) -> Array:
    """Apply the linear part of a (3, 4) transform to (..., 3) vectors."""
    return np.asarray(vectors, np.float64) @ matrix[:, :3].T


def transform_box(matrix: Array, lo: ArrayLike, hi: ArrayLike) -> tuple[Array, Array]:
    """Return the bounds (lo, hi) of transformed boxes (Arvo, "Transforming Axis-Aligned Bounding Boxes", 1990).

    matrix : (..., 3, 4); lo, hi : (..., 3)
    """
    linear, offset = matrix[..., :3], matrix[..., 3]
    first = linear * np.asarray(lo, np.float64)[..., None, :]
    second = linear * np.asarray(hi, np.float64)[..., None, :]
    return np.minimum(first, second).sum(-1) + offset, np.maximum(first, second).sum(-1) + offset


def normalize(vectors: ArrayLike) -> Array:
    """Return (..., 3) vectors at unit length; a zero vector stays zero."""
    vectors = np.asarray(vectors, np.float64)
    largest = np.abs(vectors).max(-1, keepdims=True)
    vectors = vectors / np.where(largest > 0, largest, 1)  # so that squares neither overflow nor vanish
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Array = vectors / np.where(length > 0, length, 1)
    return unit
