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
    population_count,
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
_MANY = np.int32(4)
"""Children that are tested packet by packet (see `_meet_children`)."""
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


class Box(NamedTuple):
    """A child's planes in the order in which an interval meets them."""

    near_x: object
    near_y: object
    near_z: object
    far_x: object
    far_y: object
    far_z: object


@inline
def _box(nodes, child, span):
    """Return the Box of the child at a word."""
    x, y, z = span.slab_x.near_plane, span.slab_y.near_plane, span.slab_z.near_plane
    return Box(scalar(nodes, child + x), scalar(nodes, child + y), scalar(nodes, child + z),
               scalar(nodes, child + BOTH_X - x), scalar(nodes, child + BOTH_Y - y), scalar(nodes, child + BOTH_Z - z))


@inline
def _between(p, q, inverse, near_add, far_add):
    """Return the t at which rays enter and leave the space between two planes, whichever they meet first."""
    return (minimum(fma(p, inverse, near_add), fma(q, inverse, near_add)),
            maximum(fma(p, inverse, far_add), fma(q, inverse, far_add)))


@inline
def _overlapping(box, bundle, slot, span, in_mesh):
    """Return which rays of a packet meet a box before their hit, as bits of an int64."""
    rays, t = rays_at(bundle.rays, slot), load(bundle.hits, HIT.t + slot)
    if span.mixed:  # a ray may meet its planes in the other order
        x0, x1 = _between(box.near_x, box.far_x, rays.inverse.x, rays.near_add.x, rays.far_add.x)
        y0, y1 = _between(box.near_y, box.far_y, rays.inverse.y, rays.near_add.y, rays.far_add.y)
        z0, z1 = _between(box.near_z, box.far_z, rays.inverse.z, rays.near_add.z, rays.far_add.z)
    else:
        x0, x1 = fma(box.near_x, rays.inverse.x, rays.near_add.x), fma(box.far_x, rays.inverse.x, rays.far_add.x)
        y0, y1 = fma(box.near_y, rays.inverse.y, rays.near_add.y), fma(box.far_y, rays.inverse.y, rays.far_add.y)
        z0, z1 = fma(box.near_z, rays.inverse.z, rays.near_add.z), fma(box.far_z, rays.inverse.z, rays.far_add.z)
    begin = f32(0.0)
    if in_mesh:
        begin = load(bundle.hits, HIT.begin + slot)
    entry, leave = maximum(maximum(x0, y0), maximum(z0, begin)), minimum(minimum(x1, y1), minimum(z1, t))
    return np.int64(bits(entry <= leave * BOX_SLACK)) << slot


@inline
def _meet_children(nodes, base, order, candidates, bundle, lanes, span, in_mesh, met):
    """Write to `met` which of some rays meet each candidate among a node's children, looking at packets that have any.

    Few children one after the other, each loaded once; many by one packet after the other, whose rays are loaded once.
    """
    if population_count(candidates) < _MANY:
        while candidates:
            place = np.int64(count_trailing_zeros(candidates))
            candidates &= candidates - 1
            box, left, found = _box(nodes, base + (order >> 4 * place & 7), span), lanes, np.int64(0)
            while left:
                slot = first_packet(left)
                left = without_packet(left, slot)
                found |= _overlapping(box, bundle, slot, span, in_mesh)
            met[place] = found
        return
    for place in range(8):
        met[place] = 0
    while lanes:
        slot = first_packet(lanes)
        lanes = without_packet(lanes, slot)
        left = candidates
        while left:
            place = np.int64(count_trailing_zeros(left))
            left &= left - 1
            box = _box(nodes, base + (order >> 4 * place & 7), span)
            met[place] |= _overlapping(box, bundle, slot, span, in_mesh)


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
    met = stack_longs(8)
    _meet_children(nodes, base, order, candidates, bundle, lanes, span, in_mesh, met)
    while candidates:
        place = np.int64(count_trailing_zeros(candidates))
        candidates &= candidates - 1
        k = order >> 4 * place & 7
        child, distance = scalar_int(nodes, base + NODE.child + k), scalar(entries, place)
        if in_mesh:  # without a branch on whether any ray meets it, which no processor can predict
            prefetch_subtree(scene, child)
            _write(stack, size, child, distance, met[place])
            size += np.int64(met[place] != 0)
        elif met[place]:
            _insert(stack, bottom, size, child, distance, met[place])
            size += 1
    return size
