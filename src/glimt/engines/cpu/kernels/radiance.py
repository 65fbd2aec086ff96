"""The integrator: a block of rays to radiance (Whitted, "An improved illumination model for shaded display", 1980)."""

import numpy as np
from numba import types

from glimt.engines.cpu.kernels.arrays import Arrays
from glimt.engines.cpu.kernels.block import PATH, POINT, RAY, SLOTS, Block, first_slot, lanes_of
from glimt.engines.cpu.kernels.bounce import bounce
from glimt.engines.cpu.kernels.hit import hit_at
from glimt.engines.cpu.kernels.intersect import intersect
from glimt.engines.cpu.kernels.material import material_at
from glimt.engines.cpu.kernels.resolve import add_to_pixels
from glimt.engines.cpu.kernels.shade import shade
from glimt.engines.cpu.kernels.stage_times import lap, tick
from glimt.engines.cpu.kernels.surface import above, surface_at
from glimt.kernel import SharedKernel, inline
from glimt.lanes import LANES, any_lane, bits, load, load3, scalar3, store, store3, store_scalar
from glimt.layout import BOUNCE, INTERSECT, MISS, SHADE, VIEW


@inline
def _points(scene, block, packets, spread, depth):
    """Write the surface points that rays have hit; the others see the background. Return the packets with any."""
    met = np.int64(0)
    while packets:
        slot = first_slot(packets)
        packet = packets & -packets
        packets &= packets - 1
        active, hit = lanes_of(block.active, slot), hit_at(block.hits, slot)
        found = active & (hit.inst != MISS)
        store_scalar(block.found, slot // LANES, bits(found))
        throughput = load(block.paths, PATH.throughput + slot)
        lost = active & ~found
        if any_lane(lost):
            add_to_pixels(block, slot, lost, scalar3(scene.view_words, VIEW.background) * throughput, depth)
        if not any_lane(found):
            continue
        met |= packet
        origin = load3(block.rays, RAY.origin + slot, SLOTS)
        direction = load3(block.rays, RAY.direction + slot, SLOTS)
        travelled = load(block.paths, PATH.travelled + slot) + hit.t
        store(block.paths, PATH.travelled + slot, travelled)
        surface = surface_at(scene, hit, found, origin, direction)
        material = material_at(scene, surface, found, direction, travelled * spread)
        store3(block.points, POINT.point + slot, SLOTS, surface.point)
        store3(block.points, POINT.start + slot, SLOTS, above(surface))
        store3(block.points, POINT.ng + slot, SLOTS, surface.ng)
        store(block.points, POINT.clearance + slot, surface.clearance)
        store(block.points, POINT.clear_unit + slot, surface.clear_unit)
        store3(block.points, POINT.ns + slot, SLOTS, material.ns)
        store3(block.points, POINT.diffuse + slot, SLOTS, material.diffuse)
        store3(block.points, POINT.specular + slot, SLOTS, material.specular)
        store(block.points, POINT.exponent + slot, material.exponent)
        store(block.points, POINT.reflectivity + slot, material.reflectivity)
        store3(block.points, POINT.lit + slot, SLOTS, material.ambient * scalar3(scene.view_words, VIEW.ambient))
    return met


def radiance_of_rays(tlas_nodes, tlas_blocks, blas_nodes, blas_blocks, instances, triangles, faces, vertices,
                     tangents, materials, textures, levels, texels, lights, spans, light_count, span_count, view_words,
                     counters, recorded, room, rays, hits, shadow_rays, shadow_hits, local, paths, points, sums,
                     active, found, occluders, packets, spread, max_bounces):
    """Do what `radiance` asks for."""
    scene = Arrays(tlas_nodes, tlas_blocks, blas_nodes, blas_blocks, instances, triangles, faces, vertices,
                   tangents, materials, textures, levels, texels, lights, spans, light_count, span_count, view_words,
                   counters, recorded, room)
    block = Block(rays, hits, shadow_rays, shadow_hits, local, paths, points, sums, active, found, occluders)
    packets, time = np.int64(packets), tick(scene)
    for depth in range(max_bounces + 1):
        intersect(scene, block, packets, depth == 0)
        time = lap(scene, INTERSECT, time)
        packets = _points(scene, block, packets, spread, depth)
        if packets:
            shade(scene, block, packets)
        time = lap(scene, SHADE, time)
        if packets == 0:
            return 0
        packets = bounce(block, packets, depth, max_bounces)
        time = lap(scene, BOUNCE, time)
        if packets == 0:
            return 0
    return 0


_FLOATS, _INTS, _LONGS = (types.CPointer(kind) for kind in (types.float32, types.int32, types.int64))
RADIANCE = SharedKernel(radiance_of_rays, (
    *[_FLOATS] * 15, *[types.int64] * 2, _FLOATS, _LONGS, _FLOATS, types.int64, *[_FLOATS] * 8, *[_INTS] * 3,
    types.int32, types.float32, types.int64))
_call = RADIANCE.call


@inline
def radiance(scene, block, packets, spread, max_bounces):
    """Add the radiance along the rays of some packets to their pixels: ``(1 - r) * lit + r * mirrored`` at every hit.

    `spread` is the width of a pixel's cone at distance 1.
    """
    _call((scene, block, packets, spread, max_bounces))
