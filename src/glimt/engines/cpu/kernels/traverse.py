"""Blocks of packets through the two-level tree."""

from typing import NamedTuple

import numpy as np
from numba import types

from glimt.engines.cpu.kernels.block import HIT, all_lanes_of, first_packet, lanes_in, without_packet
from glimt.engines.cpu.kernels.hit import hit_at, store_hit
from glimt.engines.cpu.kernels.packet import interval, rays_at, set_up
from glimt.engines.cpu.kernels.single import walk_each
from glimt.engines.cpu.kernels.sphere import sphere_hit
from glimt.engines.cpu.kernels.triangle import triangle_leaf
from glimt.kernel import SharedKernel, inline, routine
from glimt.lanes import (
    LANES,
    bits,
    count_trailing_zeros,
    dot,
    fma,
    highest,
    load,
    load8,
    maximum,
    minimum,
    population_count,
    prefetch,
    scalar,
    scalar3,
    scalar_int,
    stack_floats,
    stack_ints,
    stack_longs,
    store8,
    vector3,
)
from glimt.layout import (
    BOTH_X,
    BOTH_Y,
    BOTH_Z,
    BOX_SLACK,
    INSTANCE,
    INSTANCE_BLOCK,
    LEAF_STEP,
    NODE,
    SPHERE_KIND,
    TRIANGLE_BLOCK,
)

FEW = 0
NO_FLAGS, SHARED_ORIGIN, OCCLUSION = np.int32(0), np.int32(1), np.int32(2)
"""What `trace` may be told: that all rays start in one point, that it is enough to know whether anything is met."""


class Trees(NamedTuple):
    """Pointers to what rays are traced through."""

    tlas_nodes: object
    tlas_blocks: object
    blas_nodes: object
    blas_blocks: object
    instances: object


class Bundle(NamedTuple):
    """Rays of a block in the space of the tree they walk, and their hits; `local` is room for another space."""

    rays: object
    local: object
    hits: object
    shared_origin: object
    occlusion: object


@inline
def _children(nodes, base, span, limit):
    """Return (entry, exit) of an interval for the eight children of a node."""
    x, y, z = span.slab_x, span.slab_y, span.slab_z
    entry = maximum(maximum(fma(load8(nodes, base + x.near_plane), x.near_factor, x.near_add),
                            fma(load8(nodes, base + y.near_plane), y.near_factor, y.near_add)),
                    maximum(fma(load8(nodes, base + z.near_plane), z.near_factor, z.near_add), 0.0))
    leave = minimum(minimum(fma(load8(nodes, base + BOTH_X - x.near_plane), x.far_factor, x.far_add),
                            fma(load8(nodes, base + BOTH_Y - y.near_plane), y.far_factor, y.far_add)),
                    minimum(fma(load8(nodes, base + BOTH_Z - z.near_plane), z.far_factor, z.far_add), limit))
    return entry, leave * BOX_SLACK


@inline
def _overlapping(nodes, child, bundle, lanes, span):
    """Return those of some rays that meet one child's box before their hit, looking at packets that have any."""
    x, y, z = span.slab_x, span.slab_y, span.slab_z
    near_x, far_x = scalar(nodes, child + x.near_plane), scalar(nodes, child + BOTH_X - x.near_plane)
    near_y, far_y = scalar(nodes, child + y.near_plane), scalar(nodes, child + BOTH_Y - y.near_plane)
    near_z, far_z = scalar(nodes, child + z.near_plane), scalar(nodes, child + BOTH_Z - z.near_plane)
    met = np.int64(0)
    while lanes:
        slot = first_packet(lanes)
        lanes = without_packet(lanes, slot)
        rays, t = rays_at(bundle.rays, slot), load(bundle.hits, HIT.t + slot)
        x0, x1 = fma(near_x, rays.inverse.x, rays.near_add.x), fma(far_x, rays.inverse.x, rays.far_add.x)
        y0, y1 = fma(near_y, rays.inverse.y, rays.near_add.y), fma(far_y, rays.inverse.y, rays.far_add.y)
        z0, z1 = fma(near_z, rays.inverse.z, rays.near_add.z), fma(far_z, rays.inverse.z, rays.far_add.z)
        if span.mixed:  # a ray may meet its planes in the other order: its bounds are then on the wrong sides
            x0, x1 = minimum(x0, x1) - rays.mixed_pad, maximum(x0, x1) + rays.mixed_pad
            y0, y1 = minimum(y0, y1) - rays.mixed_pad, maximum(y0, y1) + rays.mixed_pad
            z0, z1 = minimum(z0, z1) - rays.mixed_pad, maximum(z0, z1) + rays.mixed_pad
        entry, leave = maximum(maximum(x0, y0), maximum(z0, 0.0)), minimum(minimum(x1, y1), minimum(z1, t))
        met |= np.int64(bits(entry <= leave * BOX_SLACK)) << slot
    return met


@inline
def _farthest(hits, packets):
    """Return the greatest t that some ray of some packets still looks up to; below 0 when all are done."""
    farthest = load(hits, HIT.t + np.int64(count_trailing_zeros(packets)) * LANES)
    packets &= packets - 1
    while packets:
        farthest = maximum(farthest, load(hits, HIT.t + np.int64(count_trailing_zeros(packets)) * LANES))
        packets &= packets - 1
    return highest(farthest)


@inline
def _write(stack, lanes, distances, place, code, which, distance):
    stack[place] = code
    lanes[place] = which
    distances[place] = distance


@inline
def _fetch(scene, nodes, child):
    """Begin to bring a child nearer: large meshes do not fit into the caches."""
    if child >= 0:
        at = np.int64(child) * NODE.words
        prefetch(nodes, at)
        prefetch(nodes, at + 16)
        prefetch(nodes, at + 32)
        prefetch(nodes, at + 48)
    else:
        at = np.int64(~child // LEAF_STEP) * TRIANGLE_BLOCK.words
        prefetch(scene.blas_blocks, at)
        prefetch(scene.blas_blocks, at + 16)
        prefetch(scene.blas_blocks, at + 32)


@inline
def _walk_few(scene, code, inst, bundle, lanes):
    """Walk rays down a mesh's tree one by one: of a packet that has fanned out, few meet what is small."""
    while lanes:
        slot = first_packet(lanes)
        rays, hit = rays_at(bundle.rays, slot), hit_at(bundle.hits, slot)
        store_hit(bundle.hits, slot, walk_each(scene, code, rays, hit, lanes_in(lanes, slot), bundle.occlusion, inst))
        lanes = without_packet(lanes, slot)


def _walk_with(leaf, few):
    """Return the walk down a tree whose leaves are tested by `leaf`, and what `few` rays meet by `_walk_few`.

    It is bound here because Numba cannot cache a kernel that passes a function as an argument.
    """
    @routine
    def walk(scene, nodes, root, bundle, packets, span, inst):
        """Walk a tree from child code `root`, nearest children first, with the packets that are still in each."""
        stack, waiting, distances, entries = stack_ints(512), stack_longs(512), stack_floats(512), stack_floats(8)
        limit = _farthest(bundle.hits, packets)
        code, here, size = np.int32(root), all_lanes_of(packets), 0
        while True:
            if population_count(here) <= few:
                _walk_few(scene, code, inst, bundle, here)
                limit = _farthest(bundle.hits, packets)
                if bundle.occlusion and limit < 0:
                    return
            elif code >= 0:
                # Eight children against the interval, then the survivors against each ray.
                base = np.int64(code) * NODE.words
                entry, leave = _children(nodes, base, span, limit)
                candidates = bits(entry <= leave)
                store8(entries, 0, entry)
                bottom = size
                while candidates:
                    k = np.int64(count_trailing_zeros(candidates))
                    candidates &= candidates - 1
                    met = _overlapping(nodes, base + k, bundle, here, span)
                    if met:
                        distance, child, place = scalar(entries, k), scalar_int(nodes, base + NODE.child + k), size
                        if not bundle.occlusion:
                            while place > bottom and scalar(distances, place - 1) < distance:
                                _write(stack, waiting, distances, place, scalar_int(stack, place - 1),
                                       waiting[place - 1], scalar(distances, place - 1))
                                place -= 1
                        _fetch(scene, nodes, child)
                        _write(stack, waiting, distances, place, child, met, distance)
                        size += 1
                if size > bottom:
                    size -= 1
                    code, here = scalar_int(stack, size), waiting[size]
                    continue
            else:
                leaf(scene, inst, ~code, bundle, here, span)
                limit = _farthest(bundle.hits, packets)
                if bundle.occlusion and limit < 0:
                    return

            # What lies behind the closest hits by now is passed over.
            while True:
                if size == 0:
                    return
                size -= 1
                if scalar(distances, size) <= limit * BOX_SLACK:
                    code, here = scalar_int(stack, size), waiting[size]
                    break

    return walk


@inline
def _triangles(scene, inst, code, bundle, lanes, span):
    """Test the triangles of a leaf of a mesh's tree."""
    while lanes:
        slot = first_packet(lanes)
        lanes = without_packet(lanes, slot)
        hit = triangle_leaf(scene, inst, code, rays_at(bundle.rays, slot), hit_at(bundle.hits, slot), bundle.occlusion)
        store_hit(bundle.hits, slot, hit)


_walk_mesh = _walk_with(_triangles, np.int64(FEW))


@inline
def _to_object(scene, record, bundle, packets):
    """Write rays in an instance's object space to `local`; directions keep their length there, so t stays the same."""
    at = record + INSTANCE.world_to_object
    x, y, z = (scalar3(scene.instances, at), scalar3(scene.instances, at + 4), scalar3(scene.instances, at + 8))
    while packets:
        slot = np.int64(count_trailing_zeros(packets)) * LANES
        packets &= packets - 1
        rays = rays_at(bundle.rays, slot)
        origin = vector3(dot(x, rays.origin) + scalar(scene.instances, at + 3),
                         dot(y, rays.origin) + scalar(scene.instances, at + 7),
                         dot(z, rays.origin) + scalar(scene.instances, at + 11))
        d = rays.direction
        set_up(bundle.local, slot, origin, vector3(dot(x, d), dot(y, d), dot(z, d)))


@inline
def _next_group(rays, todo, alone, shared_origin):
    """Return (packets, their Interval): all that are left, or only one where together they would be mixed."""
    group = todo
    if alone:
        group = todo & -todo
    span = interval(rays, group, shared_origin)
    if span.mixed and group & (group - 1):
        group = todo & -todo
        span = interval(rays, group, shared_origin)
    return group, span


@inline
def _mesh(scene, inst, record, bundle, packets):
    """Walk the mesh of an instance with packets in its space."""
    root, alone = scalar_int(scene.instances, record + INSTANCE.root), False
    while packets:
        group, span = _next_group(bundle.rays, packets, alone, bundle.shared_origin)
        alone = group != packets
        packets &= ~group
        if span.incoherent:
            slot = np.int64(count_trailing_zeros(group)) * LANES
            rays, hit = rays_at(bundle.rays, slot), hit_at(bundle.hits, slot)
            hit = walk_each(scene, root, rays, hit, np.int32(-1), bundle.occlusion, inst)
            store_hit(bundle.hits, slot, hit)
        else:
            _walk_mesh(scene, scene.blas_nodes, root, bundle, group, span, inst)


@inline
def _instances(scene, inst, code, bundle, lanes, span):
    """Test the spheres and walk the meshes of a leaf of the scene's tree."""
    base, packets = np.int64(code // LEAF_STEP) * INSTANCE_BLOCK.words, np.int32(0)
    while lanes:
        slot = first_packet(lanes)
        lanes = without_packet(lanes, slot)
        packets |= np.int32(1) << np.int32(slot // LANES)
    for j in range(code % LEAF_STEP):
        inst = scalar_int(scene.tlas_blocks, base + j)
        record = np.int64(inst) * INSTANCE.words
        if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
            todo = packets
            while todo:
                slot = np.int64(count_trailing_zeros(todo)) * LANES
                todo &= todo - 1
                rays, hit = rays_at(bundle.rays, slot), hit_at(bundle.hits, slot)
                store_hit(bundle.hits, slot, sphere_hit(scene, inst, record, rays, hit, bundle.occlusion))
        else:
            here = bundle.rays
            if scalar_int(scene.instances, record + INSTANCE.identity) == 0:
                _to_object(scene, record, bundle, packets)
                here = bundle.local
            local = Bundle(here, here, bundle.hits, bundle.shared_origin, bundle.occlusion)
            _mesh(scene, inst, record, local, packets)


_walk_scene = _walk_with(_instances, np.int64(0))


_FLOATS = types.CPointer(types.float32)


def trace_rays(tlas_nodes, tlas_blocks, blas_nodes, blas_blocks, instances, rays, local, hits, flags, packets):
    """Do what `trace` asks for: the half of every kernel that follows rays."""
    scene = Trees(tlas_nodes, tlas_blocks, blas_nodes, blas_blocks, instances)
    bundle = Bundle(rays, local, hits, flags & SHARED_ORIGIN != 0, flags & OCCLUSION != 0)
    alone = False
    while packets:
        group, span = _next_group(rays, packets, alone, bundle.shared_origin)
        alone = group != packets
        packets &= ~group
        _walk_scene(scene, tlas_nodes, np.int32(0), bundle, group, span, np.int32(0))
    return 0


TRACE = SharedKernel(trace_rays, (*[_FLOATS] * 8, types.int32, types.int32))
_call = TRACE.call


@inline
def trace(scene, rays, local, hits, flags, packets):
    """Find the hits of some packets of a block, or only whether there are any: rays are set up, hits begun."""
    _call((scene.tlas_nodes, scene.tlas_blocks, scene.blas_nodes, scene.blas_blocks, scene.instances, rays, local, hits,
           flags, packets))
