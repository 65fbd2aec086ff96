"""Rays that have nothing in common: each walks down a mesh's tree by itself, and they take turns, a node at a time.

While a ray's next node is on its way from memory, the others of the block have their turns: one after the other they
would wait for most of the time.

How many rays want a subtree, or whether a ray goes on, no processor can foresee, and a wrong guess costs as much as
half a node: there are few branches on such things. And the sooner one is found to be wrong, the less has been done for
nothing: what has come of one ray's visit is acted on after the next ray's has begun, when it is known.
"""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, SINGLE, SINGLE_WORDS, SLOTS, first_packet, without_packet
from glimt.engines.cpu.kernels.ray import MET_WORDS, children, leaf, put_single, take_hits
from glimt.kernel import inline, routine
from glimt.lanes import (
    LANES,
    as_float,
    as_int,
    bits,
    compress8,
    count_trailing_zeros,
    first_bit,
    lane_numbers,
    load8_int,
    numbers8,
    population_count,
    prefetch,
    scalar,
    scalar_int,
    select,
    shuffle,
    stack_floats,
    stack_ints,
    store,
    store8,
    store_scalar,
    unpack8,
)
from glimt.layout import BOX_SLACK, LEAF_STEP, NODE, STACK_SIZE, TRIANGLE_BLOCK

REACH = BOX_SLACK * BOX_SLACK
"""Distances on the stack of a ray may be too great by a child's number in their lowest bits."""
_LINE = 16  # words of a cache line
_PENDING = 32
"""Entries of a ray's stack for subtrees that its packet leaves to it, below those of its own walk."""
_STACK = np.int64(_PENDING + STACK_SIZE + _LINE)
"""Words from one ray's stack to the next; no power of two, so that they do not share a few places of the cache."""
_STACK_WORDS = (SLOTS + 1) * (_PENDING + STACK_SIZE + _LINE)
_BOTTOMS = SLOTS + LANES
"""One ray more than there are: what is left to that one is left to nobody."""
_TWO_VISITS = 2 * MET_WORDS
"""Words of what the ray at hand and the one before have met."""
_FEW = 3
"""A subtree is left to so few rays most often."""


class Pending(NamedTuple):
    """Subtrees that single rays still have to walk: each ray's stack, from `bottoms` up to its word _PENDING.

    `count`: how many were left to anyone, so that no ray has more.
    """

    stack: object
    distances: object
    bottoms: object
    count: object


class Visit(NamedTuple):
    """What has come of a ray's visit to a node or a leaf block.

    slot: the ray; code: of the node or leaf; top: of its stack; place: where in `met` it says where the triangles are
    that were met, and inside: which ones.
    """

    slot: object
    code: object
    top: object
    place: object
    inside: object


@inline
def new_pending():
    """Return room for subtrees that are left to the rays of a block."""
    return Pending(stack_ints(_STACK_WORDS), stack_floats(_STACK_WORDS), stack_ints(_BOTTOMS), stack_ints(1))


@inline
def leave_nothing(pending):
    """Empty all stacks."""
    for slot in range(0, _BOTTOMS, LANES):
        store(pending.bottoms, slot, (lane_numbers() + np.int32(slot)) * np.int32(_STACK) + np.int32(_PENDING))
    pending.count[0] = 0


@inline
def _leave_to_one(pending, slot, distance, code):
    """Leave a subtree to one ray, or to nobody (SLOTS), whose stack does not grow."""
    bottom = scalar_int(pending.bottoms, slot) - np.int32(slot < SLOTS)
    store_scalar(pending.bottoms, slot, bottom)
    store_scalar(pending.stack, bottom, code)
    store_scalar(pending.distances, bottom, distance)


@inline
def leave_to(pending, lanes, distance, code):
    """Leave a subtree to each ray of `lanes`, to be walked after what was left to it before.

    Return whether there was room for it in all their stacks; else nothing is left to any of them.
    """
    if pending.count[0] >= _PENDING:
        left = lanes
        while left:
            slot = np.int64(count_trailing_zeros(left))
            left &= left - 1
            if scalar_int(pending.bottoms, slot) == slot * _STACK:
                return False
    pending.count[0] += 1
    for _ in range(_FEW):  # without a branch on how many there are, which no processor can predict
        _leave_to_one(pending, np.int64(first_bit(lanes)), distance, code)
        lanes &= lanes - 1
    while lanes:
        _leave_to_one(pending, np.int64(count_trailing_zeros(lanes)), distance, code)
        lanes &= lanes - 1
    return True


@inline
def prefetch_subtree(scene, code):
    """Have a node or leaf block on its way from memory."""
    words, at = scene.blas_nodes, np.int64(code) * NODE.words
    if code < 0:
        words, at = scene.blas_blocks, np.int64(~code // LEAF_STEP) * TRIANGLE_BLOCK.words
    prefetch(words, at)
    prefetch(words, at + _LINE)
    prefetch(words, at + 2 * _LINE)
    prefetch(words, at + 3 * _LINE)


@inline
def push(nodes, code, rays, singles, hits, pending, top, slot):
    """Put the children of a node that a ray meets on its stack, the nearest on top; return the new top.

    Each is its distance, with the child's number in the lowest bits. All eight are put in order and stored, whether the
    ray meets them or not: how many it meets no processor can predict.
    """
    base = np.int64(code) * NODE.words
    entry, leave = children(nodes, base, rays, singles, hits, slot)
    met = entry <= leave
    order = unpack8(scalar_int(nodes, base + np.int64(scalar_int(singles, SINGLE.order + slot))))
    keys = shuffle(select(met, (as_int(entry) & np.int32(-8)) | numbers8(), np.int32(-1)), order)
    keys = compress8(keys, keys >= 0)
    store8(pending.stack, top, shuffle(load8_int(nodes, base + NODE.child), keys))
    store8(pending.distances, top, as_float(keys))
    return top + population_count(bits(met))


@inline
def _next(scene, hits, pending, codes, tops, top, slot):
    """Take a ray's nearest entry from its stack; return the ray's bit, 0 when none is left before its hit."""
    bottom, limit = scalar_int(pending.bottoms, slot), scalar(hits, HIT.t + slot) * REACH
    while top > bottom:
        top -= 1
        if scalar(pending.distances, top) <= limit:
            store_scalar(codes, slot, scalar_int(pending.stack, top))
            store_scalar(tops, slot, top)
            prefetch_subtree(scene, scalar_int(pending.stack, top))
            return np.int64(1) << slot
    return np.int64(0)


@inline
def _act_on(scene, inst, hits, pending, codes, tops, met, visit, occlusion):
    """Have a ray keep what it has met, and take its next entry: what lies behind its hit is passed over."""
    take_hits(scene, inst, ~visit.code, hits, visit.slot, met, visit.place, visit.inside, occlusion)
    return _next(scene, hits, pending, codes, tops, visit.top, visit.slot)


@routine
def walk_pending(scene, rays, hits, pending, lanes, occlusion, inst):
    """Walk each ray of `lanes` that still looks for something down the subtrees left to it."""
    codes, tops, singles = stack_ints(SLOTS), stack_ints(SLOTS), stack_floats(SINGLE_WORDS)
    packets = lanes
    while packets:
        put_single(rays, singles, first_packet(packets))
        packets = without_packet(packets, first_packet(packets))
    todo = np.int64(0)
    while lanes:
        slot = np.int64(count_trailing_zeros(lanes))
        lanes &= lanes - 1
        todo |= _next(scene, hits, pending, codes, tops, slot * _STACK + _PENDING, slot)
    met, zero = stack_floats(_TWO_VISITS), np.int32(0)
    while todo:
        turns, todo, before = todo, np.int64(0), Visit(np.int64(SLOTS), zero, np.int64(0), np.int64(0), zero)
        while turns:
            slot, place = np.int64(count_trailing_zeros(turns)), MET_WORDS - before.place
            turns &= turns - 1
            code, top, inside = scalar_int(codes, slot), np.int64(scalar_int(tops, slot)), zero
            if code >= 0:
                top = push(scene.blas_nodes, code, rays, singles, hits, pending, top, slot)
            else:
                inside = leaf(scene, ~code, rays, singles, hits, slot, met, place, occlusion)
            todo |= _act_on(scene, inst, hits, pending, codes, tops, met, before, occlusion)
            before = Visit(slot, code, top, place, inside)
        todo |= _act_on(scene, inst, hits, pending, codes, tops, met, before, occlusion)
