"""Blocks of packets through the two-level tree."""

import numpy as np
from numba import types

from glimt.engines.cpu.kernels.arrays import Trees
from glimt.engines.cpu.kernels.block import HIT, all_lanes_of, first_slot, packets_of
from glimt.engines.cpu.kernels.bundle import Bundle, farthest, nearest_start, start_at_once, start_in
from glimt.engines.cpu.kernels.hit import hit_at, store_hit
from glimt.engines.cpu.kernels.leaf import meet_leaf
from glimt.engines.cpu.kernels.node import IN_MESH, IN_SCENE, new_stack, push_children
from glimt.engines.cpu.kernels.packet import interval, rays_at, set_up
from glimt.engines.cpu.kernels.single import leave_nothing, leave_to, new_pending, walk_pending
from glimt.engines.cpu.kernels.sphere import sphere_hit
from glimt.kernel import SharedKernel, inline, routine
from glimt.lanes import (
    any_lane,
    as_int,
    bits,
    dot,
    load,
    load4,
    population_count,
    scalar,
    scalar3,
    scalar_int,
    vector3,
)
from glimt.layout import (
    BOX_SLACK,
    INSTANCE,
    INSTANCE_BLOCK,
    LEAF_STEP,
    MISS,
    SPAN,
    SPHERE_KIND,
    TRIANGLE_BLOCK,
)

NO_FLAGS, SHARED_ORIGIN, OCCLUSION = np.int32(0), np.int32(1), np.int32(2)
"""What `trace` may be told: that all rays start in one point, that it is enough to know whether anything is met."""

_TOGETHER, _ALONE = np.int64(5), np.int64(3)
"""Nodes of a mesh that packets visit before they leave subtrees to single rays; rays that go alone even before."""
_SPARSE = np.int64(12)
"""Rays that are so few that they walk the mesh of an instance one by one."""


@routine
def _walk_mesh(scene, root, bundle, packets, lanes, span, begin, inst, pending):
    """Walk a mesh's tree from child code `root`, nearest children first, as long as the rays go together.

    The more nodes packets have visited, the less their rays have in common: then a node that few of them want is left
    to single rays, and by and by every node. A leaf costs packets no more. Return the rays to which something was left.
    """
    stack, size, visited, left = new_stack(), np.int64(0), 0, np.int64(0)
    limit, code, here, distance = farthest(bundle.hits, packets), np.int32(root), lanes, np.float32(0)
    while True:
        if code >= 0:
            visited += 1
            size = push_children(scene, scene.blas_nodes, code, bundle, here, span, begin, limit, stack, size,
                                 IN_MESH)
        else:
            meet_leaf(scene, inst, ~code, bundle, here, distance)
            limit = farthest(bundle.hits, packets)
            if bundle.occlusion and limit < 0:
                return left
        while True:  # what lies behind the closest hits by now is passed over
            if size == 0:
                return left
            size -= 1
            distance = stack.distances[size]
            if distance <= limit * BOX_SLACK:
                code, here = stack.codes[size], stack.lanes[size]
                together = code < 0 or population_count(here) > max(visited - _TOGETHER, _ALONE)
                if together or not leave_to(pending, here, distance, code):
                    break
                left |= here


@inline
def to_object(scene, record, bundle, packets):
    """Write rays in an instance's object space to `local`; directions keep their length there, so t stays the same."""
    at = record + INSTANCE.world_to_object
    x, y, z = (scalar3(scene.instances, at), scalar3(scene.instances, at + 4), scalar3(scene.instances, at + 8))
    while packets:
        slot = first_slot(packets)
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
def _mesh(scene, inst, record, bundle, lanes, clear, pending, known, known_span):
    """Walk the mesh of an instance with packets in its space: together, by packets, or by rays.

    `clear`: whether some rays begin later than at 0; `known` are packets whose Interval there is known already.
    """
    root, alone, left = scalar_int(scene.instances, record + INSTANCE.root), np.bool_(False), np.int64(0)
    packets = packets_of(lanes)
    leave_nothing(pending)
    while packets:
        if packets == known:
            group, span = known, known_span
        else:
            group, span = _next_group(bundle.rays, packets, alone, bundle.shared_origin)
        alone = group != packets
        packets &= ~group
        here = lanes & all_lanes_of(group)
        if span.incoherent or population_count(here) <= _SPARSE:  # nothing in common to begin with
            leave_to(pending, here, np.float32(0), root)
            left |= here
        else:
            begin = nearest_start(bundle.hits, here) if clear else np.float32(0)
            left |= _walk_mesh(scene, root, bundle, group, here, span, begin, inst, pending)
    if left:
        walk_pending(scene, bundle.rays, bundle.hits, pending, left, bundle.occlusion, inst)


@inline
def _sphere(scene, inst, record, bundle, packets):
    """Test a sphere."""
    while packets:
        slot = first_slot(packets)
        packets &= packets - 1
        hit = sphere_hit(scene, inst, record, rays_at(bundle.rays, slot), hit_at(bundle.hits, slot), bundle.occlusion)
        store_hit(bundle.hits, slot, hit)


@inline
def _is_at_home(scene, record):
    """Return whether an instance's object space is the world's."""
    return scalar_int(scene.instances, record + INSTANCE.identity) != 0


@inline
def _in_space_of(scene, record, bundle, packets):
    """Return the Bundle of some packets in the space of an instance's mesh."""
    rays = bundle.rays
    if not _is_at_home(scene, record):
        to_object(scene, record, bundle, packets)
        rays = bundle.local
    return Bundle(rays, rays, bundle.hits, bundle.shared_origin, bundle.occlusion)


@inline
def _instances(scene, code, bundle, lanes, pending, packets, span):
    """Test the spheres and walk the meshes of a leaf of the scene's tree; `span` is the Interval of all `packets`."""
    base = np.int64(code // LEAF_STEP) * INSTANCE_BLOCK.words
    for j in range(code % LEAF_STEP):
        inst = scalar_int(scene.tlas_blocks, base + j)
        record = np.int64(inst) * INSTANCE.words
        if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
            _sphere(scene, inst, record, bundle, packets_of(lanes))
            continue
        known, here = packets if _is_at_home(scene, record) else np.int32(0), lanes
        clear = scalar(scene.instances, record + INSTANCE.clear_unit) != 0 and not bundle.shared_origin
        if clear:
            here = start_in(bundle.hits, inst, lanes)
        if here:
            placed = _in_space_of(scene, record, bundle, packets_of(here))
            _mesh(scene, inst, record, placed, here, clear, pending, known, span)
        if clear:
            start_at_once(bundle.hits, lanes)


@inline
def _walk_scene(scene, bundle, packets, span, pending):
    """Walk the scene's tree, nearest children first."""
    stack, size, root = new_stack(), np.int64(0), np.int32(0)
    limit, code, here = farthest(bundle.hits, packets), root, all_lanes_of(packets)
    while True:
        if code >= 0:
            size = push_children(scene, scene.tlas_nodes, code, bundle, here, span, np.float32(0), limit, stack,
                                 size, IN_SCENE)
        else:
            _instances(scene, ~code, bundle, here, pending, packets, span)
            limit = farthest(bundle.hits, packets)
            if bundle.occlusion and limit < 0:
                return
        while True:
            if size == 0:
                return
            size -= 1
            if stack.distances[size] <= limit * BOX_SLACK:
                code, here = stack.codes[size], stack.lanes[size]
                break


@inline
def _triangles_in(words, block):
    """Return how many triangles a leaf block holds: unused places, the last ones, have no primitive."""
    used = load4(words, np.int64(block) * TRIANGLE_BLOCK.words + TRIANGLE_BLOCK.prim)
    return population_count(bits(as_int(used) >= 0))


@routine
def _test_leaf(scene, inst, code, bundle, packets):
    """Test the triangles of a leaf for all rays of some packets."""
    meet_leaf(scene, inst, code, bundle, all_lanes_of(packets), np.float32(0))


@routine
def _test_everything(scene, bundle, packets):
    """Test every sphere and every triangle against some packets, one after the other, as if there were no trees."""
    for index in range(scene.span_count):
        inst, record = np.int32(index), np.int64(index) * INSTANCE.words
        if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
            _sphere(scene, inst, record, bundle, packets)
            continue
        placed, span = _in_space_of(scene, record, bundle, packets), np.int64(index) * SPAN.words
        first = scalar_int(scene.spans, span + SPAN.first_block)
        for block in range(first, first + scalar_int(scene.spans, span + SPAN.blocks)):
            code = block * LEAF_STEP + _triangles_in(scene.blas_blocks, block)
            _test_leaf(scene, inst, code, placed, packets)
            if bundle.occlusion and farthest(bundle.hits, packets) < 0:
                return


@inline
def _try_leaf(scene, inst, leaf, bundle, packets):
    """Test one leaf of an instance, or a sphere; return the packets that still look for something."""
    record = np.int64(inst) * INSTANCE.words
    if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
        _sphere(scene, inst, record, bundle, packets)
    else:
        _test_leaf(scene, inst, leaf, _in_space_of(scene, record, bundle, packets), packets)
    left = np.int64(0)
    while packets:
        if any_lane(load(bundle.hits, HIT.t + first_slot(packets)) > 0.0):
            left |= packets & -packets
        packets &= packets - 1
    return left


def trace_rays(tlas_nodes, tlas_blocks, blas_nodes, blas_blocks, instances, faces, spans, span_count, rays, local, hits,
               flags, packets, first_inst, first_leaf):
    """Do what `trace` asks for: the half of every kernel that follows rays."""
    scene = Trees(tlas_nodes, tlas_blocks, blas_nodes, blas_blocks, instances, faces, spans, span_count)
    bundle = Bundle(rays, local, hits, flags & SHARED_ORIGIN != 0, flags & OCCLUSION != 0)
    packets = np.int64(packets)
    if span_count:
        _test_everything(scene, bundle, packets)
        return 0
    pending, alone = new_pending(), np.bool_(False)
    if first_inst != MISS:
        packets = _try_leaf(scene, first_inst, np.int64(first_leaf), bundle, packets)
    while packets:
        group, span = _next_group(rays, packets, alone, bundle.shared_origin)
        alone = group != packets
        packets &= ~group
        _walk_scene(scene, bundle, group, span, pending)
    return 0


_FLOATS = types.CPointer(types.float32)
TRACE = SharedKernel(trace_rays, (*[_FLOATS] * 7, types.int64, *[_FLOATS] * 3, *[types.int32] * 4))
_call = TRACE.call


@inline
def trace(scene, rays, local, hits, flags, packets, first_inst=MISS, first_leaf=MISS):
    """Find the hits of some packets of a block, or only whether there are any: rays are set up, hits begun.

    What may be met is known with OCCLUSION from `inst` and `prim` of an earlier hit in the same scene: that leaf of an
    instance is tested first (MISS: none is).
    `scene` is `Trees` or anything that has its fields.
    """
    _call((scene.tlas_nodes, scene.tlas_blocks, scene.blas_nodes, scene.blas_blocks, scene.instances, scene.faces,
           scene.spans, scene.span_count, rays, local, hits, flags, packets, first_inst, first_leaf))
