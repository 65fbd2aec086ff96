"""Packets through the two-level tree."""

import numpy as np

from glimt.engines.cpu.kernels.hit import FAR, no_hit
from glimt.engines.cpu.kernels.packet import fill_idle, set_up
from glimt.engines.cpu.kernels.single import walk_each
from glimt.engines.cpu.kernels.sphere import sphere_hit
from glimt.engines.cpu.kernels.stack import push, push_sorted
from glimt.engines.cpu.kernels.triangle import triangle_leaf
from glimt.kernel import inline, routine
from glimt.lanes import (
    any_lane,
    bits,
    count_trailing_zeros,
    dot,
    fma,
    highest,
    load8,
    maximum,
    minimum,
    scalar,
    scalar3,
    scalar_int,
    stack_floats,
    stack_ints,
    store8,
    vector3,
)
from glimt.layout import BOTH_X, BOTH_Y, BOTH_Z, BOX_SLACK, INSTANCE, INSTANCE_BLOCK, LEAF_STEP, NODE, SPHERE_KIND


@inline
def _children(nodes, base, rays, limit):
    """Return (entry, exit) of the packet's interval for the eight children of a node."""
    x, y, z = rays.slab_x, rays.slab_y, rays.slab_z
    entry = maximum(maximum(fma(load8(nodes, base + x.near_plane), x.near_factor, x.near_add),
                            fma(load8(nodes, base + y.near_plane), y.near_factor, y.near_add)),
                    maximum(fma(load8(nodes, base + z.near_plane), z.near_factor, z.near_add), 0.0))
    leave = minimum(minimum(fma(load8(nodes, base + BOTH_X - x.near_plane), x.far_factor, x.far_add),
                            fma(load8(nodes, base + BOTH_Y - y.near_plane), y.far_factor, y.far_add)),
                    minimum(fma(load8(nodes, base + BOTH_Z - z.near_plane), z.far_factor, z.far_add), limit))
    return entry, leave * BOX_SLACK


@inline
def _overlaps(nodes, child, rays, t):
    """Return the lanes whose ray meets one child's box before t."""
    x, y, z = rays.slab_x, rays.slab_y, rays.slab_z
    x0 = fma(scalar(nodes, child + x.near_plane), rays.inverse.x, rays.near_add.x)
    x1 = fma(scalar(nodes, child + BOTH_X - x.near_plane), rays.inverse.x, rays.far_add.x)
    y0 = fma(scalar(nodes, child + y.near_plane), rays.inverse.y, rays.near_add.y)
    y1 = fma(scalar(nodes, child + BOTH_Y - y.near_plane), rays.inverse.y, rays.far_add.y)
    z0 = fma(scalar(nodes, child + z.near_plane), rays.inverse.z, rays.near_add.z)
    z1 = fma(scalar(nodes, child + BOTH_Z - z.near_plane), rays.inverse.z, rays.far_add.z)
    if rays.mixed:  # a ray may meet its planes in the other order: its bounds are then on the wrong sides
        x0, x1 = minimum(x0, x1) - rays.mixed_pad, maximum(x0, x1) + rays.mixed_pad
        y0, y1 = minimum(y0, y1) - rays.mixed_pad, maximum(y0, y1) + rays.mixed_pad
        z0, z1 = minimum(z0, z1) - rays.mixed_pad, maximum(z0, z1) + rays.mixed_pad
    return maximum(maximum(x0, y0), maximum(z0, 0.0)) <= minimum(minimum(x1, y1), minimum(z1, t)) * BOX_SLACK


def _walk_with(leaf):
    """Return the walk down a tree whose leaves are tested by `leaf`.

    It is bound here because Numba cannot cache a kernel that passes a function as an argument.
    """
    @inline
    def walk(nodes, root, rays, hit, occlusion, scene, inst):
        """Walk a tree from child code `root`, nearest children first."""
        stack, distances, entries = stack_ints(512), stack_floats(512), stack_floats(8)
        limit = highest(hit.t)
        code, size = np.int32(root), 0
        while True:
            if code >= 0:
                # Eight children against the packet's interval, then the survivors against each ray.
                base = np.int64(code) * NODE.words
                entry, leave = _children(nodes, base, rays, limit)
                candidates = bits(entry <= leave)
                store8(entries, 0, entry)
                bottom = size
                while candidates:
                    k = np.int64(count_trailing_zeros(candidates))
                    candidates &= candidates - 1
                    if any_lane(_overlaps(nodes, base + k, rays, hit.t)):
                        distance, child = scalar(entries, k), scalar_int(nodes, base + NODE.child + k)
                        if occlusion:
                            push(stack, distances, size, distance, child)
                        else:
                            push_sorted(stack, distances, bottom, size, distance, child)
                        size += 1
                if size > bottom:
                    size -= 1
                    code = scalar_int(stack, size)
                    continue
            else:
                hit = leaf(scene, inst, ~code, rays, hit, occlusion)
                limit = highest(hit.t)
                if occlusion and limit < 0:
                    return hit

            # What lies behind the closest hits by now is passed over.
            while True:
                if size == 0:
                    return hit
                size -= 1
                if scalar(distances, size) <= limit * BOX_SLACK:
                    code = scalar_int(stack, size)
                    break

    return walk


_walk_mesh = _walk_with(triangle_leaf)


@inline
def to_object(scene, record, rays):
    """Return the packet in an instance's object space; directions keep their length there, so t stays the same."""
    at = record + INSTANCE.world_to_object
    x, y, z = (scalar3(scene.instances, at), scalar3(scene.instances, at + 4), scalar3(scene.instances, at + 8))
    origin = vector3(dot(x, rays.origin) + scalar(scene.instances, at + 3),
                     dot(y, rays.origin) + scalar(scene.instances, at + 7),
                     dot(z, rays.origin) + scalar(scene.instances, at + 11))
    return set_up(origin, vector3(dot(x, rays.direction), dot(y, rays.direction), dot(z, rays.direction)),
                  rays.shared_origin)


@inline
def instance_leaf(scene, inst, code, rays, hit, occlusion):
    """Test the spheres and walk the meshes of a leaf of the scene's tree."""
    base = np.int64(code // LEAF_STEP) * INSTANCE_BLOCK.words
    for j in range(code % LEAF_STEP):
        inst = scalar_int(scene.tlas_blocks, base + j)
        record = np.int64(inst) * INSTANCE.words
        if scalar_int(scene.instances, record + INSTANCE.kind) == SPHERE_KIND:
            hit = sphere_hit(scene, inst, record, rays, hit, occlusion)
        else:
            local = rays
            if scalar_int(scene.instances, record + INSTANCE.identity) == 0:
                local = to_object(scene, record, rays)
            root = scalar_int(scene.instances, record + INSTANCE.root)
            if local.incoherent:
                hit = walk_each(scene, root, local, hit, occlusion, inst)
            else:
                hit = _walk_mesh(scene.blas_nodes, root, local, hit, occlusion, scene, inst)
    return hit


_walk_scene = _walk_with(instance_leaf)


@routine
def closest_hit(scene, origin, direction, active, shared_origin):
    """Return the nearest Hit in front of each ray of `active`; `shared_origin` says that all start in one point."""
    rays = set_up(fill_idle(active, origin), fill_idle(active, direction), shared_origin)
    return _walk_scene(scene.tlas_nodes, np.int32(0), rays, no_hit(active, FAR), np.bool_(False), scene, np.int32(0))


@routine
def occluded(scene, origin, direction, t_max, active):
    """Return the lanes of `active` in whose way something stands before t_max."""
    rays = set_up(fill_idle(active, origin), fill_idle(active, direction), np.bool_(False))
    hit = _walk_scene(scene.tlas_nodes, np.int32(0), rays, no_hit(active, t_max), np.bool_(True), scene, np.int32(0))
    return active & (hit.t < 0.0)
