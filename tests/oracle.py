"""Every ray against every primitive in float64: slow and obvious. Says what a hit may be, not only what it is.

Float32 cannot tell on which side of an edge a ray passes when it passes closer than the rounding of its own origin.
So a meeting is an interval of t, and sure or not sure, by one tolerance: TOLERANCE times what had to be added up to get
from the ray's origin to the primitive. Whatever lies further from the edge than that has to be hit.
"""

from typing import NamedTuple

import numpy as np

from glimt import linalg
from glimt.layout import MISS
from glimt.scene.sphere import Sphere

ROUNDING = 2.0**-24
"""The relative error of one float32 operation."""

TOLERANCE = 8 * ROUNDING
"""Of a point relative to a ray. From world to object space are four roundings (the matrix entry, three sums), to the
corner one, in the shear four, in each of two coordinates: 13 if all of them were as large as can be and added up. They
do not: 4 has been enough for a hundred thousand nasty rays."""


class Meetings(NamedTuple):
    """Where rays may meet primitives, all (rays, primitives): t lies within [lo, hi], barycentrics within `spread` of
    u and v; `possible` when the ray passes no further outside than rounding reaches, `sure` when it passes further
    inside than that, and lo > 0. prim and inst are (primitives,)."""

    lo: np.ndarray
    hi: np.ndarray
    possible: np.ndarray
    sure: np.ndarray
    u: np.ndarray
    v: np.ndarray
    spread: np.ndarray
    prim: np.ndarray
    inst: np.ndarray


def meetings(scene, origins, directions, tolerance=TOLERANCE):
    """Return all Meetings of n rays (float32 values) with the primitives of a scene; a sphere counts twice."""
    origins, directions = (np.broadcast_to(np.asarray(a, np.float64), (len(directions), 3))
                           for a in (origins, directions))
    parts = []
    placed = [thing for thing in scene.objects if isinstance(thing, Sphere) or len(thing.mesh.triangles)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for inst, thing in enumerate(placed):
            if isinstance(thing, Sphere):
                parts += [(*found, 0, inst) for found in _sphere(thing, origins, directions, tolerance)]
            else:
                corners = thing.mesh.positions.astype(np.float64)[thing.mesh.triangles]
                local = _to_object(thing.object_to_world, origins, directions)
                parts += [(*_triangle(*points, *local, tolerance), prim, inst) for prim, points in enumerate(corners)]
    count = len(origins)
    if not parts:
        none = np.zeros((count, 0))
        return Meetings(none, none, none > 0, none > 0, none, none, none, none[:1].ravel(), none[:1].ravel())
    lo, hi, possible, sure, u, v, spread = (np.stack([part[k] for part in parts], 1) for k in range(7))
    prim, inst = (np.array([part[k] for part in parts]) for k in (7, 8))
    return Meetings(lo, hi, possible & (hi > 0), sure & (lo > 0), u, v, spread, prim, inst)


def _to_object(matrix, origins, directions):
    """Return (origins, directions, size of what was added up for the origin, and for the direction) in object space.

    An instance that stands where it was modelled adds up nothing.
    """
    if np.array_equal(matrix, linalg.identity()):
        return origins, directions, np.zeros(len(origins)), np.zeros(len(origins))
    back = linalg.inverse(matrix)
    size = np.abs(origins) @ np.abs(back[:, :3]).T + np.abs(back[:, 3])
    along = np.abs(directions) @ np.abs(back[:, :3]).T
    return (linalg.transform_points(back, origins), linalg.transform_vectors(back, directions), size.max(1),
            along.max(1))


def _triangle(a, b, c, origins, directions, size, along, tolerance):
    """Return all that Meetings wants to know of one triangle."""
    length = np.linalg.norm(directions, axis=1)
    unit = directions / length[:, None]
    points = np.stack([a - origins, b - origins, c - origins], 1)  # ray, corner, axis
    depth = np.einsum("nka,na->nk", points, unit)
    flat = points - depth[..., None] * unit[:, None]  # seen along the ray, which is a point now
    sides = np.stack([b - a, c - b, a - c])
    edges = sides - (unit @ sides.T)[..., None] * unit[:, None]
    reach = np.abs(points).max((1, 2))
    error = tolerance * (reach + size + along / length * np.abs(depth).max(1))

    # Signed distances to the edges: on which side the ray passes, and how far.
    volumes = np.einsum("na,nka->nk", unit, np.cross(flat, edges))  # twice the areas of edge and ray
    area = unit @ np.cross(b - a, c - a)
    edge_lengths = np.linalg.norm(edges, axis=2)
    distance = np.sign(area)[:, None] * volumes / np.maximum(edge_lengths, 1e-300)
    height = np.abs(area) / np.maximum(edge_lengths.max(1), 1e-300)  # of the triangle as the ray sees it
    edge_on = height <= 8 * error
    near = _distance_to_outline(flat, edges) <= error
    sure = (distance > error[:, None]).all(1) & ~edge_on
    possible = near | ((distance >= 0).all(1) & (area != 0))

    # Where: in the plane; anywhere between the corners when its plane is seen edge-on, each as far along the ray as
    # along an axis that the ray follows most.
    weights = np.roll(volumes, -1, 1) / area[:, None]
    t = (depth * weights).sum(1)
    longest = np.abs(unit) > 0.999 * np.abs(unit).max(1, keepdims=True)
    ends = np.where(longest[:, None], points / unit[:, None], depth[..., None])
    first, last = ends.min((1, 2)), ends.max((1, 2))
    spread = np.where(edge_on, np.inf, 4 * ROUNDING + 2 * error / np.maximum(height, 1e-300))
    slack = np.where(edge_on, np.inf, error + 2 * spread * (last - first))
    lo, hi = np.fmax(t - slack, first - 2 * error), np.fmin(t + slack, last + 2 * error)
    return lo / length, hi / length, possible, sure, weights[:, 1], weights[:, 2], spread


def _distance_to_outline(flat, edges):
    """Return how far the origin is from the nearest edge, as a segment."""
    squared = np.einsum("nka,nka->nk", edges, edges)
    along = np.clip(-np.einsum("nka,nka->nk", flat, edges) / np.where(squared > 0, squared, 1), 0, 1)
    return np.linalg.norm(flat + along[..., None] * edges, axis=2).min(1)


def _sphere(sphere, origins, directions, tolerance):
    """Yield what Meetings wants to know of the way in and of the way out."""
    center, radius = np.asarray(sphere.center, np.float32).astype(np.float64), float(np.float32(sphere.radius))
    length = np.linalg.norm(directions, axis=1)
    unit = directions / length[:, None]
    to_center = center - origins
    nearest = np.einsum("na,na->n", to_center, unit)
    beside = np.linalg.norm(to_center - nearest[:, None] * unit, axis=1)
    error = tolerance * (np.abs(to_center).max(1) + radius)
    longest = np.sqrt(np.maximum(radius**2 - np.maximum(beside - error, 0)**2, 0))
    shortest = np.sqrt(np.maximum(radius**2 - (beside + error)**2, 0))
    possible, sure = beside - error <= radius, beside + error < radius
    zero = np.zeros(len(length))
    for lo, hi in ((nearest - longest, nearest - shortest), (nearest + shortest, nearest + longest)):
        yield (lo - error) / length, (hi + error) / length, possible, sure, zero, zero, zero


def closest(found):
    """Return (t, inst, prim) of the nearest possible meetings, t inf and MISS where there is none."""
    t = np.where(found.possible, np.maximum(found.lo, 0) / 2 + found.hi / 2, np.inf)
    if not t.shape[1]:
        return np.full(len(t), np.inf), np.full(len(t), MISS), np.full(len(t), MISS)
    first = t.argmin(1)
    t = t[np.arange(len(t)), first]
    return t, np.where(t < np.inf, found.inst[first], MISS), np.where(t < np.inf, found.prim[first], MISS)


def wrong_hits(found, hits):
    """Return which of the tracer's answers rounding does not excuse, (n,) bool.

    A hit is right when its primitive may be met at that t and these barycentrics, and nothing is sure to be met before;
    a miss when nothing is sure to be met at all.
    """
    t, u, v, prim, inst = (np.asarray(hits[name]).astype(np.float64)[:, None] for name in hits.dtype.names)
    same = (found.prim == prim) & (found.inst == inst) & found.possible
    with np.errstate(invalid="ignore"):  # barycentrics of a triangle without an area are NaN, their spread is inf
        away = np.fmax(np.abs(found.u - u), np.abs(found.v - v))
        within = (away <= found.spread) | (found.spread == np.inf)
    in_triangle = (u >= 0) & (v >= 0) & (u + v <= 1 + 4 * ROUNDING)
    fits = (same & (found.lo <= t) & (t <= found.hi) & within & in_triangle).any(1)
    first_sure = np.where(found.sure, found.hi, np.inf).min(1, initial=np.inf)
    is_miss = inst[:, 0] == MISS
    return np.where(is_miss, first_sure < np.inf, ~fits | (first_sure < t[:, 0]))


def wrong_answers(found, blocked, t_max):
    """Return which answers of a shadow ray rounding does not excuse, (n,) bool."""
    must = (found.sure & (found.hi < t_max)).any(1)
    may = (found.possible & (found.lo < t_max)).any(1)
    return np.where(blocked, ~may, must)
