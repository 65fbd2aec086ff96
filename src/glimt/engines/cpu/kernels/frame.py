"""The entry point: the tiles of a frame."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.block import PACKETS, SUM_WORDS, new_block
from glimt.engines.cpu.kernels.create_rays import BLOCK_HEIGHT, BLOCK_WIDTH, create_rays
from glimt.engines.cpu.kernels.occluder import forget_occluders
from glimt.engines.cpu.kernels.radiance import RADIANCE, radiance
from glimt.engines.cpu.kernels.resolve import begin_pixels, resolve
from glimt.engines.cpu.kernels.stage_times import lap, tick
from glimt.engines.cpu.kernels.tile import take_tile
from glimt.engines.cpu.kernels.totals import PLACE_WORDS, add_samples, put_places
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.kernel import calls, kernel
from glimt.lanes import atomic_load, scalar, scalar_int, stack_floats, stack_ints, store_scalar
from glimt.layout import CANCEL, CREATE_RAYS, RESOLVE, TILE_SIDE, TOGETHER, VIEW


@calls(RADIANCE, TRACE)
@kernel
def render_tiles(scene, light_count, view, film, samples, max_bounces, control, counters, recorded):
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
        Shared by all threads: the flag to stop, how work is divided, and how many tiles are taken.
    counters : int64 array
        This thread's own, with its share of the tiles, and the ticks of stages if it says so.
    recorded : (3, 7, n) float32
        Receives up to n primary, shadow and mirror rays each: origin, direction, how far they look. For one thread.
    """
    here = arrays(scene, light_count, view, counters, recorded)
    block, totals, inside = new_block(), stack_floats(SUM_WORDS), stack_ints(PACKETS)
    places, height, width, centre = stack_ints(PLACE_WORDS), film.shape[0], film.shape[1], np.float32(0.5)
    put_places(places, samples)
    forget_occluders(block)
    step = np.float32(1) / np.float32(samples)
    spread = scalar(here.view_words, VIEW.spread) * step
    side, together = control[TILE_SIDE], control[TOGETHER]
    while True:
        left, top = take_tile(control, counters, width, height, side)
        if top < 0:
            return
        for y in range(top, min(top + side, height), BLOCK_HEIGHT):
            for x in range(left, min(left + side, width), BLOCK_WIDTH):
                begin_pixels(totals)
                for sample in range(samples * samples):
                    if atomic_load(control, CANCEL) != 0:
                        return
                    column, row = sample % samples * BLOCK_WIDTH, sample // samples * BLOCK_HEIGHT
                    start = tick(here)
                    packets = create_rays(here, block, x * samples + column, y * samples + row, centre, centre,
                                          width * samples, height * samples)
                    lap(here, CREATE_RAYS, start)
                    begin_pixels(block.sums)
                    for k in range(PACKETS):
                        store_scalar(inside, k, scalar_int(block.active, k))
                    for first in range(0, PACKETS, together):
                        group = packets & np.int32(((1 << together) - 1) << first)
                        if group:
                            radiance(here, block, group, spread, max_bounces)
                    start = tick(here)
                    add_samples(here, totals, block.sums, inside, places, samples, column, row)
                    lap(here, RESOLVE, start)
                start = tick(here)
                resolve(film, totals, np.float32(samples * samples), x, y)
                lap(here, RESOLVE, start)
