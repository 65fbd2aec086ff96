"""Adaptive supersampling: more samples where a pixel and those around it differ, until the mean can be trusted.

After Whitted, "An improved illumination model for shaded display" (1980), who divides a pixel further where its corners
differ, and Mitchell, "Generating antialiased images at low sampling densities" (1987), who decides by contrast. Unlike
theirs the samples are those of the 4×4 grid, four at a time, and the end is told by the error of their mean.
"""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.block import PACKETS, SLOTS, new_block
from glimt.engines.cpu.kernels.contrast import (
    CODE_WORDS,
    CONTRAST_WORDS,
    code,
    contrast_at,
    exposed,
    load_contrasts,
)
from glimt.engines.cpu.kernels.create_rays import PACKET_HEIGHT, PACKET_WIDTH, packet_pixels, put_rays
from glimt.engines.cpu.kernels.occluder import forget_occluders
from glimt.engines.cpu.kernels.radiance import RADIANCE, radiance
from glimt.engines.cpu.kernels.resolve import begin_pixels, finite_samples, store_pixel
from glimt.engines.cpu.kernels.tile import take_tile
from glimt.engines.cpu.kernels.totals import fours
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.kernel import calls, inline, kernel
from glimt.lanes import (
    LANES,
    any_lane,
    atomic_load,
    bits,
    compress_store,
    compress_store3,
    count_trailing_zeros,
    extract,
    f32,
    gather,
    gather_int,
    lane_numbers,
    load,
    load3,
    load_int,
    maximum,
    pointer,
    population_count,
    scalar,
    select,
    shuffle,
    splat3,
    sqrt,
    stack_floats,
    store,
    store3,
    store_scalar,
    to_float,
    vector3,
)
from glimt.layout import CANCEL, TILE, VIEW

GRID = 4
"""A pixel has up to GRID×GRID samples, in rounds of one for each row and each column."""
_COLUMNS = np.int32(0b10_00_11_01)
"""Column of the sample in each row, the first one lowest, in the first round; in others it is moved by xor."""
_ROUNDS = (0, 3, 1, 2)

_GRID_BITS = np.int32(GRID.bit_length() - 1)
_PIXELS, _AT_ONCE = SLOTS // GRID, LANES // GRID
"""Pixels whose samples of a round make up a block, and a packet."""

FIRST_FOOTPRINT = np.float32(0.7)
"""Width of the first sample's cone in pixels. Mip levels are as blurred as a wide filter: of one sample with a whole
pixel's cone more are off than of one with this."""
_LEAST_CONTRAST = np.float32(7)
"""Codes. Pixels that differ less from those around keep their first sample."""
_LARGEST_ERROR = np.float32(4.5)
"""Codes: the error of a mean that needs no more samples."""
_DOUBT = np.float32(0.4)
"""Share of the contrast that is taken for a spread that the samples have missed."""

_PLANE = TILE * TILE + LANES
_PIXEL, _CONTRAST, _SUM, _SQUARE = 0, _PLANE, 2 * _PLANE, 5 * _PLANE
TODO_WORDS = 8 * _PLANE
"""Pixels that need more samples, side by side: number in the tile, contrast, sum of samples, sum of their squares."""
_TILE_BITS = TILE.bit_length() - 1


class RefineMemory(NamedTuple):
    """Pointers: codes and contrasts of a tile and around it, and the pixels that need more samples."""

    codes: object
    contrasts: object
    todo: object


@inline
def new_refine_memory():
    """Return memory of the calling kernel."""
    return RefineMemory(stack_floats(CODE_WORDS), stack_floats(CONTRAST_WORDS), stack_floats(TODO_WORDS))


@inline
def _keep_first(film, first, left, top, right, bottom):
    """Copy the samples of the first picture."""
    words, from_words, width = pointer(film), pointer(first), film.shape[1]
    for y in range(top, bottom):
        for at in range(4 * (y * width + left), 4 * (y * width + right)):
            store_scalar(words, at, scalar(from_words, at))


@inline
def _find_pixels(scene, codes, contrasts, todo, first, left, top):
    """Write the pixels of a tile that need more samples, and return how many there are."""
    load_contrasts(scene, codes, contrasts, first, left, top)
    count = 0
    none = splat3(f32(0.0))
    for y in range(0, TILE, PACKET_HEIGHT):
        for x in range(0, TILE, PACKET_WIDTH):
            columns, rows = packet_pixels(0, x, y)
            inside = (columns + np.int32(left) < np.int32(first.shape[1])) & (
                rows + np.int32(top) < np.int32(first.shape[0]))
            pixel = rows * np.int32(TILE) + columns
            value = contrast_at(contrasts, columns, rows)
            needed = inside & (value > _LEAST_CONTRAST)
            store3(todo, _SUM + count, _PLANE, none)
            store3(todo, _SQUARE + count, _PLANE, none)
            compress_store(todo, _PIXEL + count, pixel, needed)
            compress_store(todo, _CONTRAST + count, value, needed)
            count += population_count(bits(needed))
    return count


@inline
def _places(pixel, left, top):
    """Return (column, row) in the picture of some pixels of the tile at (left, top)."""
    return (pixel & np.int32(TILE - 1)) + np.int32(left), (pixel >> np.int32(_TILE_BITS)) + np.int32(top)


@inline
def _pixels_of(start, k, count):
    """Return (which pixels packet k of a block has samples of, whether there are such); `start` is the first one."""
    pixels = (lane_numbers() >> _GRID_BITS) + np.int32(start + k * _AT_ONCE)
    return pixels, pixels < np.int32(count)


@inline
def _create_rays(scene, block, todo, start, count, number, left, top, width, height):
    """Write rays through the samples that some pixels have in a round, from pixel `start` of `count` on.

    The samples of a pixel are side by side. Return the packets with any.
    """
    step, row, packets = np.float32(1) / np.float32(GRID), lane_numbers() & np.int32(GRID - 1), np.int32(0)
    column = ((_COLUMNS >> (row << 1)) & np.int32(GRID - 1)) ^ np.int32(_ROUNDS[number])
    shift_x, shift_y = (to_float(column) + np.float32(0.5)) * step, (to_float(row) + np.float32(0.5)) * step
    for k in range(PACKETS):
        pixels, active = _pixels_of(start, k, count)
        store_scalar(block.active, k, bits(active))
        if any_lane(active):
            packets |= np.int32(1) << np.int32(k)
            columns, rows = _places(gather_int(todo, pixels + np.int32(_PIXEL), active), left, top)
            put_rays(scene, block, k, columns, rows, shift_x, shift_y, width, height)
    return packets


@inline
def _add_fours(todo, at, v):
    """Add the GRID samples of each pixel of a packet to what its pixels have from `at` on, a word each."""
    firsts = shuffle(fours(v, 1, 2), lane_numbers() << _GRID_BITS)
    store(todo, at, load(todo, at) + select(lane_numbers() < np.int32(_AT_ONCE), firsts, 0.0))


@inline
def _add_samples(scene, block, todo, start, count):
    """Add the samples that rays have brought, and their squares, to the sums of the pixels from `start` on."""
    for k in range(PACKETS):
        light = finite_samples(scene, block.sums, np.int64(k * LANES), _pixels_of(start, k, count)[1])
        square, at = _squares(scene, light), start + k * _AT_ONCE
        _add_fours(todo, _SUM + at, light.x)
        _add_fours(todo, _SUM + _PLANE + at, light.y)
        _add_fours(todo, _SUM + 2 * _PLANE + at, light.z)
        _add_fours(todo, _SQUARE + at, square.x)
        _add_fours(todo, _SQUARE + _PLANE + at, square.y)
        _add_fours(todo, _SQUARE + 2 * _PLANE + at, square.z)


@inline
def _channel_error(scene, mean, square, samples):
    """Return by how many codes the mean of some samples of a pixel is expected to differ from that of all, squared.

    The variance of the mean of n of N values is variance * (1 / n - 1 / N) if they are drawn at random.
    """
    variance = maximum(square * (np.float32(1) / samples) - mean * mean, 0.0) * (samples / (samples - np.float32(1)))
    deviation = sqrt(variance * _missing(samples))
    error = (code(scene, mean + deviation) - code(scene, mean - deviation)) * 0.5
    return error * error


@inline
def _missing(samples):
    return np.float32(1) / samples - np.float32(1 / (GRID**2 + 1))


@inline
def _trusted(scene, total, square, contrast, samples):
    """Return the lanes whose mean can be trusted."""
    per_sample = np.float32(1) / samples * scalar(scene.view_words, VIEW.exposure)
    error = maximum(_channel_error(scene, total.x * per_sample, square.x, samples),
                    maximum(_channel_error(scene, total.y * per_sample, square.y, samples),
                            _channel_error(scene, total.z * per_sample, square.z, samples)))
    doubt = contrast * contrast * (_DOUBT * _DOUBT * _missing(samples))
    return error + doubt < _LARGEST_ERROR * _LARGEST_ERROR


@inline
def _squares(scene, light):
    x, y, z = exposed(scene, light.x), exposed(scene, light.y), exposed(scene, light.z)
    return vector3(x * x, y * y, z * z)


@inline
def _samples_of(first, pixel, left, top):
    """Return the first samples of some pixels of the tile at (left, top)."""
    columns, rows = _places(pixel, left, top)
    words, at = pointer(first), (rows * np.int32(first.shape[1]) + columns) << 2
    everywhere = lane_numbers() >= 0
    return vector3(gather(words, at, everywhere), gather(words, at + 1, everywhere), gather(words, at + 2, everywhere))


@inline
def _write(film, pixel, lanes, total, samples, left, top):
    """Write the sums of some pixels to the film."""
    words, width = pointer(film), film.shape[1]
    todo = bits(lanes)
    while todo:
        lane = count_trailing_zeros(todo)
        todo &= todo - 1
        number = np.int64(extract(pixel, lane))
        store_pixel(words, (top + number // TILE) * width + left + number % TILE, total, lane, samples)


@inline
def _settle(scene, film, first, todo, at, count, kept, number, left, top):
    """Write those of LANES pixels from `at` on that have enough samples after a round, and keep the others.

    Return how many are kept by now: they move to the front, where there is nothing left to be read.
    """
    active, samples = lane_numbers() < np.int32(count - at), np.float32(GRID * (number + 1))
    pixel, contrast = select(active, load_int(todo, _PIXEL + at), 0), load(todo, _CONTRAST + at)
    total, square = load3(todo, _SUM + at, _PLANE), load3(todo, _SQUARE + at, _PLANE)
    done, shown, among = active, total, samples
    if number < GRID - 1:  # the first sample counts until the grid is full
        light = _samples_of(first, pixel, left, top)
        shown, among = total + light, samples + np.float32(1)
        done = active & _trusted(scene, shown, square + _squares(scene, light), contrast, among)
    _write(film, pixel, done, shown, among, left, top)
    rest = active & ~done
    if any_lane(rest):
        compress_store(todo, _PIXEL + kept, pixel, rest)
        compress_store(todo, _CONTRAST + kept, contrast, rest)
        compress_store3(todo, _SUM + kept, _PLANE, total, rest)
        compress_store3(todo, _SQUARE + kept, _PLANE, square, rest)
    return kept + population_count(bits(rest))


@inline
def refine_tile(scene, block, memory, film, first, left, top, max_bounces, control):
    """Write the tile at (left, top): first samples, or with 4, 8 or 12 more, or the 16 of the grid.

    `first` is a film of one sample a pixel, finished also around the tile. Return False if another thread asks to stop.
    """
    todo = memory.todo
    height, width = film.shape[0], film.shape[1]
    _keep_first(film, first, left, top, min(left + TILE, width), min(top + TILE, height))
    count = _find_pixels(scene, memory.codes, memory.contrasts, todo, first, left, top)
    spread = scalar(scene.view_words, VIEW.spread) * np.float32(1 / GRID)
    for number in range(GRID):
        kept = 0
        for start in range(0, count, _PIXELS):
            if atomic_load(control, CANCEL) != 0:
                return False
            packets = _create_rays(scene, block, todo, start, count, number, left, top, width, height)
            begin_pixels(block.sums)
            radiance(scene, block, packets, spread, max_bounces)
            _add_samples(scene, block, todo, start, count)
            for at in range(start, min(start + _PIXELS, count), LANES):
                kept = _settle(scene, film, first, todo, at, count, kept, number, left, top)
        count = kept
    return True


@calls(RADIANCE, TRACE)
@kernel
def refine_tiles(scene, light_count, view, film, first, max_bounces, control, counters, recorded):
    """Refine tiles until none is left or another thread asks to stop.

    `first` is a film of one sample a pixel, finished; the rest is as for `frame.render_tiles`.
    """
    here = arrays(scene, light_count, view, counters, recorded)
    block, memory = new_block(), new_refine_memory()
    forget_occluders(block)
    while True:
        left, top = take_tile(control, counters, film.shape[1], film.shape[0])
        if top < 0 or not refine_tile(here, block, memory, film, first, left, top, max_bounces, control):
            return
