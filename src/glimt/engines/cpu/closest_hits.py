"""Rays through glimt's own kernels."""

import numpy as np
from numpy.typing import NDArray

from glimt.engines.cpu.kernels.query import NO_SOURCES, find_hits
from glimt.packed import PackedScene

_GRANULE = 16  # rays are asked in whole packets of every width


def closest_hits(packed: PackedScene, rays: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return (3, n) t, u, v and (2, n) prim, inst (MISS: none) of what (7, n) rays meet first, n any number.

    A prim is a triangle by its number in the mesh.
    """
    count = rays.shape[1]
    padded = np.concatenate([rays, np.repeat(rays[:, -1:], -count % _GRANULE, 1)], 1)
    floats, ids = np.zeros((3, padded.shape[1]), np.float32), np.zeros((2, padded.shape[1]), np.int32)
    find_hits(packed, padded, NO_SOURCES, False, floats, ids, np.zeros(1, np.int64))
    ids[0] = packed.numbers_in_mesh(*ids)
    return floats[:, :count], ids[:, :count]
