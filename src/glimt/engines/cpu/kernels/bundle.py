"""Rays of a block on their way through a tree: where they begin in it, and how far they still look."""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, first_packet, first_slot, lanes_of_packet, without_packet
from glimt.engines.cpu.kernels.hit import FAR
from glimt.kernel import inline
from glimt.lanes import bits, f32, from_bits, highest, load, load_int, lowest, maximum, minimum, select, store


class Bundle(NamedTuple):
    """Rays of a block in the space of the tree they walk, and their hits; `local` is room for another space."""

    rays: object
    local: object
    hits: object
    shared_origin: object
    occlusion: object


@inline
def farthest(hits, packets):
    """Return the greatest t that some ray of some packets still looks up to; below 0 when all are done."""
    farthest = load(hits, HIT.t + first_slot(packets))
    packets &= packets - 1
    while packets:
        farthest = maximum(farthest, load(hits, HIT.t + first_slot(packets)))
        packets &= packets - 1
    return highest(farthest)


@inline
def start_in(hits, inst, lanes):
    """Write where some rays begin in the tree of an instance; return those that do before they end."""
    started, todo = np.int64(0), lanes
    while todo:
        slot = first_packet(todo)
        todo = without_packet(todo, slot)
        begin = select(load_int(hits, HIT.source + slot) == inst, load(hits, HIT.clear + slot), 0.0)
        store(hits, HIT.begin + slot, begin)
        started |= np.int64(bits(begin < load(hits, HIT.t + slot))) << slot
    return started & lanes


@inline
def start_at_once(hits, lanes):
    """Have some rays begin in trees where they begin in the scene."""
    while lanes:
        slot = first_packet(lanes)
        lanes = without_packet(lanes, slot)
        store(hits, HIT.begin + slot, f32(0.0))


@inline
def nearest_start(hits, lanes):
    """Return the least t at which one of some rays begins."""
    nearest = f32(FAR)
    while lanes:
        slot = first_packet(lanes)
        here = from_bits(lanes_of_packet(lanes, slot))
        lanes = without_packet(lanes, slot)
        nearest = minimum(nearest, select(here, load(hits, HIT.begin + slot), FAR))
    return lowest(nearest)
