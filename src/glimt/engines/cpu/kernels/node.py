"""Nodes of a tree against packets, and what of it is still to be visited."""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, first_packet, without_packet
from glimt.engines.cpu.kernels.packet import rays_at
from glimt.engines.cpu.kernels.single import prefetch_subtree
from glimt.kernel import inline
from glimt.lanes import (
    bits,
    count_trailing_zeros,
    f32,
    fma,
    load,
    load8,
    maximum,
    minimum,
    scalar,
    scalar_int,
    shuffle,
    stack_floats,
    stack_ints,
    stack_longs,
    store8,
    unpack8,
)
from glimt.layout import BOTH_X, BOTH_Y, BOTH_Z, BOX_SLACK, NODE, STACK_SIZE

IN_SCENE, IN_MESH = np.bool_(False), np.bool_(True)
"""Which tree `push_children` is in: in the scene's, all rays begin at 0."""
_AS_THEY_ARE = np.int64(0x76543210)
"""A node's children in the order of their numbers (see `layout.NODE`)."""


@inline
def _children(nodes, base, span, begin, limit):
    """Return (entry, exit) of an interval, from `begin` to `limit`, for the eight children of a node."""
    x, y, z = span.slab_x, span.slab_y, span.slab_z
    entry = maximum(maximum(fma(load8(nodes, base + x.near_plane), x.near_factor, x.near_add),
                            fma(load8(nodes, base + y.near_plane), y.near_factor, y.near_add)),
                    maximum(fma(load8(nodes, base + z.near_plane), z.near_factor, z.near_add), begin))
    leave = minimum(minimum(fma(load8(nodes, base + BOTH_X - x.near_plane), x.far_factor, x.far_add),
                            fma(load8(nodes, base + BOTH_Y - y.near_plane), y.far_factor, y.far_add)),
                    minimum(fma(load8(nodes, base + BOTH_Z - z.near_plane), z.far_factor, z.far_add), limit))
    return entry, leave * BOX_SLACK


@inline
def _overlapping(nodes, child, bundle, lanes, span, in_mesh):
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
        begin = f32(0.0)
        if in_mesh:
            begin = load(bundle.hits, HIT.begin + slot)
        entry, leave = maximum(maximum(x0, y0), maximum(z0, begin)), minimum(minimum(x1, y1), minimum(z1, t))
        met |= np.int64(bits(entry <= leave * BOX_SLACK)) << slot
    return met


class Stack(NamedTuple):
    """What is still to be visited: child codes, how far each child is, and the rays that want it."""

    codes: object
    distances: object
    lanes: object


@inline
def new_stack():
    """Return room on the stack of the calling kernel."""
    return Stack(stack_ints(STACK_SIZE), stack_floats(STACK_SIZE), stack_longs(STACK_SIZE))


@inline
def _write(stack, place, code, distance, lanes):
    stack.codes[place] = code
    stack.distances[place] = distance
    stack.lanes[place] = lanes


@inline
def _insert(stack, bottom, size, code, distance, lanes):
    """Put an entry on the stack so that those from `bottom` on are sorted, the nearest on top."""
    while size > bottom and stack.distances[size - 1] < distance:
        _write(stack, size, stack.codes[size - 1], stack.distances[size - 1], stack.lanes[size - 1])
        size -= 1
    _write(stack, size, code, distance, lanes)


@inline
def push_children(scene, nodes, code, bundle, lanes, span, begin, limit, stack, bottom, in_mesh):
    """Put the children of a node that some ray meets on the stack, the nearest on top; return its size.

    Eight children against the interval, then the survivors against each ray. They come in the order of the octant, but
    in the scene's tree, where boxes are of all sizes and lie within each other, by distance.
    """
    base, size, entries, order = np.int64(code) * NODE.words, bottom, stack_floats(8), _AS_THEY_ARE
    entry, leave = _children(nodes, base, span, begin, limit)
    if in_mesh:
        order = np.int64(scalar_int(nodes, base + span.order))
        entry, leave = shuffle(entry, unpack8(order)), shuffle(leave, unpack8(order))
    candidates = bits(entry <= leave)
    store8(entries, 0, entry)
    while candidates:
        place = np.int64(count_trailing_zeros(candidates))
        candidates &= candidates - 1
        k = order >> 4 * place & 7
        met = _overlapping(nodes, base + k, bundle, lanes, span, in_mesh)
        if met:
            child, distance = scalar_int(nodes, base + NODE.child + k), scalar(entries, place)
            if in_mesh:
                prefetch_subtree(scene, child)
                _write(stack, size, child, distance, met)
            else:
                _insert(stack, bottom, size, child, distance, met)
            size += 1
    return size
