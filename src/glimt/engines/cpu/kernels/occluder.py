"""What stands before a light often stands before it in the next block too, and is tested before any tree is walked.

Haines and Greenberg, "The light buffer: a shadow-testing accelerator" (1986), call it shadow caching. What differs:
only a leaf that alone blocked all rays of the last block is tested; among triangles smaller than a block there is none,
and none is paid for. Nor are mirror rays told from others. Films are the same to the bit, since whether a ray is
blocked does not depend on what is tested first.
"""

import numpy as np

from glimt.engines.cpu.kernels.block import HIT, OCCLUDER_WORDS, first_slot
from glimt.engines.cpu.kernels.traverse import OCCLUSION, trace
from glimt.kernel import inline
from glimt.lanes import any_lane, bits, count_trailing_zeros, extract, load, load_int, scalar_int, store_scalar
from glimt.layout import MISS


@inline
def forget_occluders(block):
    """Begin a picture: what a thread knows of another scene's leaves must not be tested in this one."""
    for place in range(OCCLUDER_WORDS):
        store_scalar(block.occluders, place, MISS)


@inline
def _common_occluder(hits, packets):
    """Return (instance, leaf) of what alone blocked all shadow rays of some packets; (MISS, MISS): nothing did."""
    slot = first_slot(packets)
    insts, leaves = load_int(hits, HIT.inst + slot), load_int(hits, HIT.prim + slot)
    if any_lane(load(hits, HIT.t + slot) > 0.0):
        return MISS, MISS
    lane = count_trailing_zeros(bits(insts != MISS))
    inst, leaf = extract(insts, lane), extract(leaves, lane)
    differing = (insts != MISS) & ((insts != inst) | (leaves != leaf))
    packets &= packets - 1
    while packets:
        slot = first_slot(packets)
        packets &= packets - 1
        insts, leaves = load_int(hits, HIT.inst + slot), load_int(hits, HIT.prim + slot)
        unblocked = load(hits, HIT.t + slot) > 0.0
        differing = differing | unblocked | ((insts != MISS) & ((insts != inst) | (leaves != leaf)))
    if any_lane(differing):
        return MISS, MISS
    return inst, leaf


@inline
def trace_shadow_rays(scene, block, packets, index):
    """Find which shadow rays of some packets to light number `index` are blocked; each packet has some."""
    place = 2 * np.int64(index) & (OCCLUDER_WORDS - 1)  # lights beyond the last place share those of the first
    trace(scene, block.shadow_rays, block.local, block.shadow_hits, OCCLUSION, packets,
          scalar_int(block.occluders, place), scalar_int(block.occluders, place + 1))
    inst, leaf = _common_occluder(block.shadow_hits, packets)
    store_scalar(block.occluders, place, inst)
    store_scalar(block.occluders, place + 1, leaf)
