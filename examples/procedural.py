"""Textures from noise: tileable stone, with normal maps from the height field that also colours it.

A height field is (size, size) float64 in metres, row 0 on top, and stands for a square of `tile` metres. All randomness
comes from a seed, so the same numbers come out every time.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float64]


class Texture(NamedTuple):
    """A colour map (sRGB) and its normal map, both (size, size, 3) uint8, and the height field both came from."""

    color: NDArray[np.uint8]
    normal: NDArray[np.uint8]
    height: Field


class Blocks(NamedTuple):
    """Where a texel lies in a wall of blocks, (size, size) each."""

    block: NDArray[np.int64]
    """Number of its block."""
    edge: Field
    """Distance to the rounded outline of its block, in metres."""
    across: Field
    """-1 at the left end of its block to 1 at the right end."""
    along: Field
    """-1 at the top of its block to 1 at the bottom."""


def noise(rng: np.random.Generator, size: int, slope: float, lowest: float = 1, highest: float = 1e9) -> Field:
    """Return tileable noise of mean 0 and deviation 1, (size, size); amplitude falls as frequency^-slope.

    `lowest` and `highest` bound the frequencies, in cycles per tile. A spectrum has no seam: the picture it gives is
    periodic by construction.
    """
    spectrum = np.fft.rfft2(rng.random((size, size)) - 0.5)
    frequency = np.hypot(np.fft.fftfreq(size, 1 / size)[:, None], np.fft.rfftfreq(size, 1 / size))
    band = (frequency >= lowest) * np.exp(-((frequency / highest) ** 2))
    values = np.fft.irfft2(spectrum * band * np.maximum(frequency, 1) ** -slope, (size, size))
    return (values - values.mean()) / values.std()


def smoothstep(lo: float, hi: float, x: Field) -> Field:
    """Return 0 below `lo`, 1 above `hi`, a smooth step between."""
    t = np.clip((x - lo) / (hi - lo), 0, 1)
    return t * t * (3 - 2 * t)


def courses(rng: np.random.Generator, size: int, tile: float, rows: int, columns: int,
            corner: float = 0.03, irregular: float = 0, bond: bool = False, wander: float = 0) -> Blocks:
    """Return a wall of `rows` courses of `columns` blocks each, tileable in both directions.

    `corner` is the radius of the corners and `wander` how far edges leave the straight line, in metres; `irregular`
    (0 to 1) varies the sizes of the blocks, `bond` shifts the courses against each other.
    """
    texel = (np.arange(size) + 0.5) / size
    y = (texel[:, None] + noise(rng, size, 1.5, 2, 40) * wander / tile) % 1
    x = texel[None, :] + noise(rng, size, 1.5, 2, 40) * wander / tile
    row_ends = _ends(rng, rows, irregular * 0.5)
    row = np.minimum(np.searchsorted(row_ends, y, "right") - 1, rows - 1)
    column, dx, across = np.zeros_like(row), np.zeros_like(y), np.zeros_like(y)
    for r in range(rows):
        ends, here = _ends(rng, columns, irregular), row == r
        shift = (r % 2 / 2 + 0.3 * irregular * (rng.random() - 0.5)) / columns if bond else 0.0
        position = (x[here] - shift) % 1
        column[here] = np.minimum(np.searchsorted(ends, position, "right") - 1, columns - 1)
        left, right = ends[column[here]], ends[column[here] + 1]
        dx[here] = np.minimum(position - left, right - position)
        across[here] = (2 * position - left - right) / (right - left)
    top, bottom = row_ends[row], row_ends[row + 1]
    dx, dy = dx * tile, np.minimum(y - top, bottom - y) * tile
    rounded = corner - np.hypot(np.maximum(corner - dx, 0), np.maximum(corner - dy, 0))
    edge = np.where((dx < corner) & (dy < corner), rounded, np.minimum(dx, dy))
    return Blocks(row * columns + column, edge, across, (2 * y - top - bottom) / (bottom - top))


def _ends(rng: np.random.Generator, count: int, irregular: float) -> Field:
    """Return count + 1 increasing positions from 0 to 1."""
    sizes = 1 + irregular * (rng.random(count) - 0.5)
    return np.concatenate([[0], np.cumsum(sizes) / sizes.sum()])


def normal_map(height: Field, tile: float) -> NDArray[np.uint8]:
    """Return the normals of a tileable height field as ``n / 2 + 1 / 2``, +Y up (OpenGL's convention)."""
    spacing = 2 * tile / len(height)
    right = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / spacing
    up = (np.roll(height, 1, 0) - np.roll(height, -1, 0)) / spacing
    normal = np.stack([-right, -up, np.ones_like(height)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return to_bytes(normal / 2 + 0.5)


def to_bytes(values: Field) -> NDArray[np.uint8]:
    """Return values of 0 to 1 as 0 to 255, clipped."""
    return np.round(np.clip(values, 0, 1) * 255).astype(np.uint8)
