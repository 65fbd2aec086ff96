"""What the way of a camera ray costs: the nodes and triangle blocks that it visits on its own.

Packets share visits, so that theirs are no property of a pixel. Here each ray walks down both trees by itself, nearest
children first, as single rays do in a picture, and passes over what lies behind the closest hit so far.
"""

import numpy as np

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.cpu.kernels.block import HIT, RAY, SINGLE_WORDS, SLOTS, first_slot, lanes_of, new_block
from glimt.engines.cpu.kernels.bundle import Bundle
from glimt.engines.cpu.kernels.create_rays import BLOCK_HEIGHT, BLOCK_WIDTH, create_rays
from glimt.engines.cpu.kernels.debug import store_numbers
from glimt.engines.cpu.kernels.hit import FAR, begin_hits, hit_at, replace, store_hit
from glimt.engines.cpu.kernels.packet import fill_idle, rays_at, set_up
from glimt.engines.cpu.kernels.ray import MET_WORDS, leaf, put_single, take_hits
from glimt.engines.cpu.kernels.single import REACH, Pending, push
from glimt.engines.cpu.kernels.sphere import sphere_hit
from glimt.engines.cpu.kernels.tile import take_tile
from glimt.engines.cpu.kernels.traverse import to_object
from glimt.kernel import inline, kernel, routine
from glimt.lanes import (
    LANES,
    atomic_load,
    bits,
    count_trailing_zeros,
    f32,
    i32,
    lane_numbers,
    load3,
    scalar,
    scalar_int,
    stack_floats,
    stack_ints,
    store_scalar,
)
from glimt.layout import CANCEL, INSTANCE, INSTANCE_BLOCK, LEAF_STEP, MISS, SPHERE_KIND, STACK_SIZE, TILE

_STACK_WORDS = 2 * STACK_SIZE + 16
"""A mesh is walked on top of what is left of the scene's tree; eight children are stored at a time."""


@inline
def _pop(stack, hits, top, bottom, slot):
    """Return (whether there is a next entry before the hit, its place on the stack)."""
    limit = scalar(hits, HIT.t + slot) * REACH
    while top > bottom:
        top -= 1
        if scalar(stack.distances, top) <= limit:
            return True, top
    return False, bottom


@routine
def _walk_mesh(scene, inst, root, rays, singles, hits, stack, bottom, slot):
    """Walk one ray down a mesh's tree; return how many nodes and triangle blocks it visits."""
    nodes, blocks, code, top, more, met = 0, 0, np.int32(root), bottom, True, stack_floats(MET_WORDS)
    while more:
        if code >= 0:
            nodes += 1
            top = push(scene.blas_nodes, code, rays, singles, hits, stack, top, slot)
        else:
            blocks += 1
            inside = leaf(scene, ~code, rays, singles, hits, slot, met, np.int64(0), False)
            take_hits(scene, inst, ~code, hits, slot, met, np.int64(0), inside, False)
        more, top = _pop(stack, hits, top, bottom, slot)
        code = scalar_int(stack.stack, top)
    return nodes, blocks


@inline
def _sort(stack, bottom, top):
    """Sort entries by distance, the nearest on top, as packets do in the scene's tree."""
    for end in range(bottom + 1, top):
        code, distance, place = scalar_int(stack.stack, end), scalar(stack.distances, end), end
        while place > bottom and scalar(stack.distances, place - 1) < distance:
            store_scalar(stack.stack, place, scalar_int(stack.stack, place - 1))
            store_scalar(stack.distances, place, scalar(stack.distances, place - 1))
            place -= 1
        store_scalar(stack.stack, place, code)
        store_scalar(stack.distances, place, distance)


@inline
def _sphere(scene, inst, record, block, slot):
    """Test a sphere for one ray, with its packet."""
    first = slot & np.int64(-LANES)
    hit = hit_at(block.hits, first)
    new = sphere_hit(scene, inst, record, rays_at(block.rays, first), hit, False)
    only = lane_numbers() == np.int32(slot - first)
    store_hit(block.hits, first, replace(hit, only, new.t, new.u, new.v, new.prim, new.inst))


@inline
def _mesh(scene, inst, record, block, singles, local_singles, stack, top, slot):
    """Walk the mesh of an instance, in its space; return how many nodes and triangle blocks the ray visits."""
    root, rays, own = scalar_int(scene.instances, record + INSTANCE.root), block.rays, singles
    if scalar_int(scene.instances, record + INSTANCE.identity) == 0:
        rays, own = block.local, local_singles
        packet = np.int32(1) << np.int32(slot // LANES)
        to_object(scene, record, Bundle(block.rays, rays, block.hits, True, False), packet)
        put_single(rays, own, slot & np.int64(-LANES))
    return _walk_mesh(scene, inst, root, rays, own, block.hits, stack, top, slot)


@inline
def _walk_scene(scene, block, singles, local_singles, stack, slot):
    """Walk one ray down the scene's tree; return how many nodes, triangle blocks and instances it visits."""
    nodes, blocks, instances, code, top, more = 0, 0, 0, np.int32(0), np.int64(0), True
    while more:
        if code >= 0:
            nodes += 1
            bottom = top
            top = push(scene.tlas_nodes, code, block.rays, singles, block.hits, stack, bottom, slot)
            _sort(stack, bottom, top)
        else:
            base = np.int64(~code // LEAF_STEP) * INSTANCE_BLOCK.words
            for j in range(~code % LEAF_STEP):
                inst = scalar_int(scene.tlas_blocks, base + j)
                record = np.int64(inst) * INSTANCE.words
                instances += 1
                if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
                    _sphere(scene, inst, record, block, slot)
                else:
                    more_nodes, more_blocks = _mesh(scene, inst, record, block, singles, local_singles, stack, top,
                                                    slot)
                    nodes += more_nodes
                    blocks += more_blocks
        more, top = _pop(stack, block.hits, top, 0, slot)
        code = scalar_int(stack.stack, top)
    return nodes, blocks, instances


@inline
def _count(scene, block, packets, singles, local_singles, stack):
    """Write to the sums what the rays of some packets visit."""
    while packets:
        slot = first_slot(packets)
        packets &= packets - 1
        active = lanes_of(block.active, slot)
        set_up(block.rays, slot, fill_idle(active, load3(block.rays, RAY.origin + slot, SLOTS)),
               fill_idle(active, load3(block.rays, RAY.direction + slot, SLOTS)))
        begin_hits(block.hits, slot, active, FAR, f32(0.0), i32(MISS))
        put_single(block.rays, singles, slot)
        todo = bits(active)
        while todo:
            at = slot + count_trailing_zeros(todo)
            todo &= todo - 1
            nodes, blocks, instances = _walk_scene(scene, block, singles, local_singles, stack, at)
            store_scalar(block.sums, at, np.float32(nodes))
            store_scalar(block.sums, at + SLOTS, np.float32(blocks))
            store_scalar(block.sums, at + 2 * SLOTS, np.float32(instances))


@kernel
def count_visits(scene, light_count, view, values, control, counters, recorded):
    """Write to `values` how many nodes, triangle blocks and instances the ray of each pixel visits.

    Spheres count as instances; the root of the scene's tree is a node. The rest is as for `debug.debug_tiles`.
    """
    here = arrays(scene, light_count, view, counters, recorded)
    block, singles, local_singles = new_block(), stack_floats(SINGLE_WORDS), stack_floats(SINGLE_WORDS)
    stack = Pending(stack_ints(_STACK_WORDS), stack_floats(_STACK_WORDS), stack_ints(1), stack_ints(1))
    height, width, centre = values.shape[0], values.shape[1], np.float32(0.5)
    while True:
        left, top = take_tile(control, counters, width, height)
        if top < 0:
            return
        for y in range(top, min(top + TILE, height), BLOCK_HEIGHT):
            for x in range(left, min(left + TILE, width), BLOCK_WIDTH):
                if atomic_load(control, CANCEL) != 0:
                    return
                packets = create_rays(here, block, x, y, centre, centre, width, height)
                _count(here, block, packets, singles, local_singles, stack)
                store_numbers(values, block, x, y, True)
