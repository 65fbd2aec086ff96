"""How much a first picture varies around each pixel of a tile, as codes of the 8-bit picture it will become."""

import numpy as np

from glimt.color import filmic
from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    absolute,
    f32,
    gather,
    lane_numbers,
    load,
    maximum,
    minimum,
    pointer,
    power,
    scalar,
    scalar_int,
    select,
    store,
)
from glimt.layout import TILE, VIEW

_STRIDE = (TILE + 4 + LANES - 1) // LANES * LANES
_PLANE = (TILE + 4) * _STRIDE
CODE_WORDS = 3 * _PLANE + LANES
"""Red, green and blue of a tile with two more pixels on each side."""
CONTRAST_WORDS = (TILE + 2) * _STRIDE + LANES
"""Contrast of a tile with one more pixel on each side."""

_DIAGONAL = np.float32(0.5)
"""Weight of diagonal neighbours: they lie 1.4 times as far away, and touch the pixel in a corner only."""
_BRIGHTEST = np.float32(1e4)


@inline
def exposed(scene, radiance):
    """Return radiance as it is exposed; what is too bright to make a difference is cut off, so it can be squared."""
    return minimum(radiance * scalar(scene.view_words, VIEW.exposure), _BRIGHTEST)


@inline
def code(scene, light):
    """Return the sRGB code, 0 to 255 and not rounded, that exposed light is developed to (see `color.develop`)."""
    x = minimum(maximum(light, 0.0), _BRIGHTEST)
    if scalar_int(scene.view_words, VIEW.filmic) != 0:
        x = filmic(x)
    x = minimum(x, 1.0)
    bright = np.float32(1.055) * power(maximum(x, np.float32(1e-3)), np.float32(1 / 2.4)) - np.float32(0.055)
    return select(x <= np.float32(0.0031308), x * np.float32(12.92), bright) * np.float32(255)


@inline
def _load_codes(scene, codes, first, left, top):
    """Write the codes of the tile at (left, top) and around it; beyond the picture its outermost pixels go on."""
    height, width = first.shape[0], first.shape[1]
    words = pointer(first)
    everywhere = lane_numbers() >= 0
    for row in range(TILE + 4):
        y = min(max(top + row - 2, 0), height - 1)
        for column in range(0, _STRIDE, LANES):
            x = minimum(maximum(lane_numbers() + np.int32(left + column - 2), 0), np.int32(width - 1))
            at = (x + np.int32(y * width)) << 2
            for k in range(3):
                value = gather(words, at + np.int32(k), everywhere)
                store(codes, k * _PLANE + row * _STRIDE + column, code(scene, exposed(scene, value)))


@inline
def _difference(codes, row, column):
    """Return how LANES pixels differ from the eight around.

    The mean of two numbers: the largest difference, and the largest bend of a line through the pixel and two opposite
    neighbours, since of an even slope one sample in the middle is the mean.
    """
    largest, bend = f32(0.0), f32(0.0)
    for k in range(3):
        centre = k * _PLANE + (row + 1) * _STRIDE + column + 1
        here = load(codes, centre)
        for axis in range(4):
            step = (1, _STRIDE, _STRIDE + 1, _STRIDE - 1)[axis]
            weight = np.float32(1.0) if axis < 2 else _DIAGONAL
            before, after = load(codes, centre - step) - here, load(codes, centre + step) - here
            largest = maximum(largest, maximum(absolute(before), absolute(after)) * weight)
            bend = maximum(bend, absolute(before + after) * weight)
    return (largest + bend) * 0.5


@inline
def load_contrasts(scene, codes, contrasts, first, left, top):
    """Write how the pixels of the tile at (left, top), and one more on each side, differ from those around them.

    `first` is a film of one sample a pixel, `codes` memory to work in.
    """
    _load_codes(scene, codes, first, left, top)
    for row in range(TILE + 2):
        for column in range(0, _STRIDE, LANES):
            store(contrasts, row * _STRIDE + column, _difference(codes, row, column))


@inline
def contrast_at(contrasts, columns, rows):
    """Return the contrast of pixels of the tile: half their own, half the mean of the nine around.

    A pixel in the midst of a texture is like the others, whatever its one sample has met.
    """
    everywhere = lane_numbers() >= 0
    at = (rows + 1) * np.int32(_STRIDE) + columns + 1
    total = f32(0.0)
    for dy in range(-1, 2):
        for dx in range(-1, 2):
            total = total + gather(contrasts, at + np.int32(dy * _STRIDE + dx), everywhere)
    return gather(contrasts, at, everywhere) * 0.5 + total * np.float32(0.5 / 9)
