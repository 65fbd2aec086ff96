"""The entry point: tiles of a frame, handed out by an atomic counter."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.create_rays import BLOCK_HEIGHT, BLOCK_WIDTH, block_pixels, create_rays
from glimt.engines.cpu.kernels.radiance import radiance
from glimt.engines.cpu.kernels.resolve import drop_non_finite, resolve
from glimt.kernel import kernel
from glimt.lanes import atomic_add, atomic_load, f32, scalar, splat3
from glimt.layout import CANCEL, NEXT_TILE, VIEW

TILE = 16
"""Pixels along a tile's side: a unit of work, and what one thread alone writes to."""


@kernel
def render_tiles(scene, light_count, view, film, samples, max_bounces, control, counters):
    """Render tiles until none is left or another thread asks to stop.

    Parameters
    ----------
    scene : PackedScene
    light_count : int
    view : VIEW words
    film : (height, width, 4) float32
        Receives the sums of radiance and the number of samples.
    samples, max_bounces : int
    control : int64 array
        Shared by all threads: the next tile's number, and the flag to stop.
    counters : int64 array
        This thread's own.
    """
    here = arrays(scene, light_count, view, counters)
    height, width = film.shape[0], film.shape[1]
    across = (width + TILE - 1) // TILE
    tiles = across * ((height + TILE - 1) // TILE)
    step = np.float32(1) / np.float32(samples)
    spread = scalar(here.view_words, VIEW.spread) * step
    while True:
        tile = atomic_add(control, NEXT_TILE, 1)
        if tile >= tiles:
            return
        left, top = (tile % across) * TILE, (tile // across) * TILE
        for y in range(top, min(top + TILE, height), BLOCK_HEIGHT):
            for x in range(left, min(left + TILE, width), BLOCK_WIDTH):
                columns, rows = block_pixels(x, y)
                inside = (columns < np.int32(width)) & (rows < np.int32(height))
                sums = splat3(f32(0.0))
                for sample in range(samples * samples):
                    if atomic_load(control, CANCEL) != 0:
                        return
                    shift_x = (np.float32(sample % samples) + np.float32(0.5)) * step
                    shift_y = (np.float32(sample // samples) + np.float32(0.5)) * step
                    origin, direction = create_rays(here, columns, rows, shift_x, shift_y, width, height)
                    light = radiance(here, origin, direction, spread, inside, max_bounces)
                    sums = sums + drop_non_finite(here, light, inside)
                resolve(film, sums, np.float32(samples * samples), x, y)
