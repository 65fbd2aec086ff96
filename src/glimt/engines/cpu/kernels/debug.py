"""Debug views: one number or vector a pixel instead of radiance, for the ray through the pixel's centre.

The integrator, told that there are no lights and no bounces, leaves in the block what is wanted: hits and surface
points, the same as in a picture. It is not compiled again for that.
"""

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.block import HIT, PACKETS, POINT, SLOTS, first_slot, new_block
from glimt.engines.cpu.kernels.create_rays import BLOCK_HEIGHT, BLOCK_WIDTH, create_rays, first_pixel
from glimt.engines.cpu.kernels.hit import hit_at
from glimt.engines.cpu.kernels.occluder import forget_occluders
from glimt.engines.cpu.kernels.radiance import RADIANCE, radiance
from glimt.engines.cpu.kernels.resolve import begin_pixels, store_inside
from glimt.engines.cpu.kernels.shade import put_shadow_rays
from glimt.engines.cpu.kernels.tile import take_tile
from glimt.engines.cpu.kernels.traverse import OCCLUSION, TRACE, trace
from glimt.kernel import calls, inline, kernel
from glimt.lanes import (
    LANES,
    as_float,
    atomic_load,
    f32,
    load,
    load3,
    pointer,
    scalar,
    scalar3,
    select,
    select3,
    store3,
    vector3,
)
from glimt.layout import CANCEL, MISS, TILE, VIEW

DEPTH, BARYCENTRICS, INSTANCES, NORMALS, SHADOWS = range(5)
"""What `debug_tiles` may be asked for."""


@inline
def _put_numbers(block, packets, shows):
    """Write to the sums what the rays of some packets have met; nothing of what follows a miss is looked at."""
    while packets:
        slot = first_slot(packets)
        packets &= packets - 1
        hit = hit_at(block.hits, slot)
        numbers = vector3(hit.t, 0.0, 0.0)
        if shows == BARYCENTRICS:
            numbers = vector3(1.0 - hit.u - hit.v, hit.u, hit.v)
        elif shows == INSTANCES:
            numbers = vector3(as_float(hit.inst), as_float(hit.prim), 0.0)
        elif shows == NORMALS:
            numbers = load3(block.points, POINT.ns + slot, SLOTS)
        store3(block.sums, slot, SLOTS, numbers)


@inline
def _add_lights(scene, block, packets, tints):
    """Add to the sums the tints of the lights that reach the surface points of some packets."""
    begin_pixels(block.sums)
    for index in range(scene.light_count):
        if tints[index, 0] + tints[index, 1] + tints[index, 2] == 0:  # a light that is not asked for
            continue
        todo = put_shadow_rays(scene, block, packets, index)
        if todo == 0:
            continue
        trace(scene, block.shadow_rays, block.local, block.shadow_hits, OCCLUSION, todo)
        tint = scalar3(pointer(tints), 3 * index)
        while todo:
            slot = first_slot(todo)
            todo &= todo - 1
            before = load3(block.sums, slot, SLOTS)
            reached = load(block.shadow_hits, HIT.t + slot) > 0.0
            store3(block.sums, slot, SLOTS, select3(reached, before + tint, before))


@inline
def store_numbers(values, block, left, top, always):
    """Write the sums of a block to its pixels, and 1 where its rays have met something; 0 elsewhere.

    always : bool
        Whether the sums count also where nothing was met.
    """
    height, width, words = values.shape[0], values.shape[1], pointer(values)
    for k in range(PACKETS):
        slot = np.int64(k * LANES)
        met = hit_at(block.hits, slot).inst != MISS
        share = select(met, f32(1.0), 0.0)
        numbers = load3(block.sums, slot, SLOTS)
        if not always:
            numbers = select3(met, numbers, 0.0)
        x, y = first_pixel(k, left, top)
        store_inside(words, x, y, width, height, numbers, share)


@calls(RADIANCE, TRACE)
@kernel
def debug_tiles(scene, light_count, view, values, shows, tints, control, counters, recorded):
    """Write what tiles show until none is left or another thread asks to stop.

    Parameters
    ----------
    values : (height, width, 4) float32
        Receives three numbers a pixel, and 1 where the ray meets something; all 0 where it does not. Of DEPTH: the
        distance. Of BARYCENTRICS: the shares of the three corners. Of INSTANCES: instance and primitive, int32 bits. Of
        NORMALS: the shading normal. Of SHADOWS: the sum of the tints of the lights that reach the point.
    shows : int
    tints : (light_count, 3) float32
        Linear colours.

    The rest is as for `frame.render_tiles`.
    """
    lit, unlit = arrays(scene, light_count, view, counters, recorded), arrays(scene, 0, view, counters, recorded)
    block = new_block()
    forget_occluders(block)
    height, width, centre = values.shape[0], values.shape[1], np.float32(0.5)
    spread = scalar(lit.view_words, VIEW.spread)
    while True:
        left, top = take_tile(control, counters, width, height)
        if top < 0:
            return
        for y in range(top, min(top + TILE, height), BLOCK_HEIGHT):
            for x in range(left, min(left + TILE, width), BLOCK_WIDTH):
                if atomic_load(control, CANCEL) != 0:
                    return
                packets = create_rays(lit, block, x, y, centre, centre, width, height)
                begin_pixels(block.sums)
                radiance(unlit, block, packets, spread, 0)
                if shows == SHADOWS:
                    _add_lights(lit, block, packets, tints)
                else:
                    _put_numbers(block, packets, shows)
                store_numbers(values, block, x, y, False)
