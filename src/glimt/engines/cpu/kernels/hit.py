"""The small answer of traversal: what surface is built from later."""

from typing import NamedTuple

import numpy as np

from glimt.kernel import inline
from glimt.lanes import f32, i32, select
from glimt.layout import MISS

FAR = np.float32(np.inf)
DONE = np.float32(-np.inf)
"""`t` of lanes that look for nothing: idle ones, and shadow rays that have met something."""


class Hit(NamedTuple):
    """Closest so far: ray parameter, barycentrics, primitive within its mesh, instance (MISS: none)."""

    t: object
    u: object
    v: object
    prim: object
    inst: object


@inline
def no_hit(active, t_max):
    """Return the Hit to start with: lanes of `active` look as far as t_max."""
    return Hit(select(active, f32(t_max), DONE), f32(0.0), f32(0.0), i32(MISS), i32(MISS))


@inline
def closer(hit, t, inst, prim):
    """Return the lanes where a hit at t replaces `hit`.

    Ties go to the lower instance and primitive: the answer does not depend on the order in which a tree is walked.
    """
    before = (hit.inst > inst) | ((hit.inst == inst) & (hit.prim > prim))
    return (t > 0.0) & ((t < hit.t) | ((t == hit.t) & before))


@inline
def replace(hit, lanes, t, u, v, prim, inst):
    """Return `hit` with a new answer in `lanes`."""
    return Hit(select(lanes, t, hit.t), select(lanes, u, hit.u), select(lanes, v, hit.v),
               select(lanes, prim, hit.prim), select(lanes, inst, hit.inst))


@inline
def block(hit, lanes):
    """Return `hit` with a shadow ray's answer in `lanes`: something is in the way."""
    return Hit(select(lanes, DONE, hit.t), hit.u, hit.v, hit.prim, hit.inst)
