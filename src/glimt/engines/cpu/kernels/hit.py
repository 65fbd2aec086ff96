"""The small answer of traversal: what surface is built from later."""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.block import HIT
from glimt.kernel import inline
from glimt.lanes import any_lane, f32, i32, load, load_int, pick_int, scalar_int, select, store
from glimt.layout import FACE, INSTANCE, MISS

FAR = np.float32(np.inf)
DONE = np.float32(-np.inf)
"""`t` of lanes that look for nothing: idle ones, and shadow rays that have met something."""


class Hit(NamedTuple):
    """Closest so far: ray parameter, barycentrics, TRIANGLE record within its mesh, instance (MISS: none)."""

    t: object
    u: object
    v: object
    prim: object
    inst: object


@inline
def no_hit(active, t_max):
    """Return the Hit to start with: lanes of `active` look as far as t_max."""
    return Hit(select(active, t_max, f32(DONE)), f32(0.0), f32(0.0), i32(MISS), i32(MISS))


@inline
def begin_hits(words, slot, active, t_max, clear, source):
    """Write the hits of a packet to start with: lanes of `active` look as far as t_max (for the rest see `HIT`)."""
    store_hit(words, slot, no_hit(active, t_max))
    store(words, HIT.clear + slot, clear)
    store(words, HIT.source + slot, source)
    store(words, HIT.begin + slot, f32(0.0))


@inline
def number_of(scene, inst, prim, lanes):
    """Return which triangle of its mesh a primitive of an instance is, or for each of `lanes` another one."""
    first = scalar_int(scene.instances, np.int64(inst) * INSTANCE.words + INSTANCE.first_triangle)
    return pick_int(scene.faces, (prim + first) * np.int32(FACE.words) + np.int32(FACE.number), lanes)


@inline
def closer(scene, hit, t, inst, prim, lanes):
    """Return those of some lanes where a triangle at t replaces `hit`.

    Ties go to the lower instance, and to the triangle with the lower number in its mesh: the answer does not depend on
    a tree, or on the order in which it is walked.
    """
    ahead = lanes & (t > 0.0)
    closest, tied = ahead & (t < hit.t), ahead & (t == hit.t)
    if any_lane(tied):
        same = tied & (hit.inst == inst)
        later = number_of(scene, inst, hit.prim, same) > number_of(scene, inst, np.int32(prim), same)
        closest = closest | (tied & (hit.inst > inst)) | (same & later)
    return closest


@inline
def replace(hit, lanes, t, u, v, prim, inst):
    """Return `hit` with a new answer in `lanes`."""
    return Hit(select(lanes, t, hit.t), select(lanes, u, hit.u), select(lanes, v, hit.v),
               select(lanes, prim, hit.prim), select(lanes, inst, hit.inst))


@inline
def block(hit, lanes, leaf, inst):
    """Return `hit` with a shadow ray's answer in `lanes`: something of a leaf is in the way (`prim` holds the leaf)."""
    return Hit(select(lanes, DONE, hit.t), hit.u, hit.v, select(lanes, leaf, hit.prim), select(lanes, inst, hit.inst))


@inline
def hit_at(words, slot):
    """Return the hits of a packet of a HIT block."""
    return Hit(load(words, HIT.t + slot), load(words, HIT.u + slot), load(words, HIT.v + slot),
               load_int(words, HIT.prim + slot), load_int(words, HIT.inst + slot))


@inline
def store_hit(words, slot, hit):
    """Write the hits of a packet to its slots of a HIT block."""
    store(words, HIT.t + slot, hit.t)
    store(words, HIT.u + slot, hit.u)
    store(words, HIT.v + slot, hit.v)
    store(words, HIT.prim + slot, hit.prim)
    store(words, HIT.inst + slot, hit.inst)
