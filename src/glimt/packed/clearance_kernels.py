"""How far from each triangle nothing stands in the way of rays that leave it.

A ray that leaves a surface spends most of its time on the surface's own neighbours, which it cannot hit unless the
surface is hollow there. So for each triangle and a few elevations one distance is worked out ahead: a ray that rises
more steeply meets nothing of the mesh before that. On a scanned mesh it is mostly many triangles long, often endless.

After Max, "Horizon mapping: shadows for bump-mapped surfaces" (1988), where a horizon tells which light arrives. What
differs: here it is a bound for all points of a triangle and all directions around it, each with the distance up to
which it holds, and what it leaves open is traced.
"""

from typing import NamedTuple

import numpy as np

from glimt.kernel import inline, kernel, routine
from glimt.lanes import (
    LANES,
    absolute,
    any_lane,
    as_int,
    cross,
    dot,
    f32,
    fma,
    load,
    load4,
    load_int,
    lowest,
    maximum,
    minimum,
    pointer,
    reciprocal,
    scalar,
    scalar_int,
    select,
    sqrt,
    stack_floats,
    stack_ints,
    store,
    store_scalar,
    vector3,
)
from glimt.layout import (
    CLEAR_BIAS,
    CLEAR_SHIFT,
    CLEAR_SINES,
    FACE,
    LEAF_SIZE,
    LEAF_STEP,
    NODE,
    STACK_SIZE,
    TRIANGLE_BLOCK,
)

_GROUP = LANES // int(LEAF_SIZE)  # leaf blocks whose triangles are looked from at once
_PLANES = 10 * LANES
_AXIS, _CORNER = np.int64(LEAF_SIZE), np.int64(3 * LEAF_SIZE)
_ENDLESS, _TINY = np.float32(3e38), np.float32(1e-36)
_COARSE = np.float32(0.4)
"""A box whose sides add up to less than this share of its distance is not looked into."""
_SHORTER = np.float32(0.999)
_LEAST_SINE = np.float32(1e-3)
"""Of angles: rounding turns the normal of a triangle with sides closer together, or a direction closer to that normal,
by more than what rays are given."""
_S0, _S1, _S2, _S3 = CLEAR_SINES
_T0, _T1, _T2, _T3 = (np.float32(sine / (1 - sine * sine) ** 0.5) for sine in CLEAR_SINES)  # tangents


class _Views(NamedTuple):
    """Triangles from which the rest is seen, one in each lane.

    corner, edge1, edge2: where each is; normal: unit, on the side that is looked from; out_a, out_b, out_c: unit
    vectors out of its sides, in its plane; low, high: its box; lift: what is lower above its plane does not count;
    sound: whether its normal can be told.
    """

    corner: object
    edge1: object
    edge2: object
    normal: object
    out_a: object
    out_b: object
    out_c: object
    low: object
    high: object
    lift: object
    sound: object


class _Clear(NamedTuple):
    """How far each triangle sees nothing above each elevation, the lowest first."""

    r0: object
    r1: object
    r2: object
    r3: object


@inline
def _unit(v):
    """Return a vector of any length at unit length; 0 where it is 0."""
    v = v * reciprocal(maximum(absolute(v.x), maximum(absolute(v.y), maximum(absolute(v.z), _TINY))))
    return v * reciprocal(sqrt(maximum(dot(v, v), _TINY)))


@inline
def _part_of(part, whole):
    """Return a part of a vector at unit length; 0 where it is so small that rounding decides where it points."""
    return _unit(part) * select(dot(part, part) > _LEAST_SINE * _LEAST_SINE * dot(whole, whole), f32(1.0), 0.0)


@inline
def _views(planes, side, lift):
    """Return the _Views of triangles whose corners lie in nine planes."""
    a = vector3(load(planes, 0), load(planes, LANES), load(planes, 2 * LANES))
    b = vector3(load(planes, 3 * LANES), load(planes, 4 * LANES), load(planes, 5 * LANES))
    c = vector3(load(planes, 6 * LANES), load(planes, 7 * LANES), load(planes, 8 * LANES))
    edge1, edge2 = b - a, c - a
    area = cross(_unit(edge1), _unit(edge2))
    normal = _unit(area)
    out_a, out_b, out_c = _unit(cross(edge1, normal)), _unit(cross(c - b, normal)), _unit(cross(normal, edge2))
    low = vector3(minimum(a.x, minimum(b.x, c.x)), minimum(a.y, minimum(b.y, c.y)), minimum(a.z, minimum(b.z, c.z)))
    high = vector3(maximum(a.x, maximum(b.x, c.x)), maximum(a.y, maximum(b.y, c.y)), maximum(a.z, maximum(b.z, c.z)))
    return _Views(a, edge1, edge2, normal * side, out_a, out_b, out_c, low, high, f32(lift),
                  dot(area, area) > _LEAST_SINE * _LEAST_SINE)


@inline
def _gap(low, high, box_low, box_high):
    """Return how far two intervals are apart."""
    return maximum(maximum(box_low - high, low - box_high), 0.0)


@inline
def _less(r, stands, distance):
    """Return r, in some lanes no more than a distance."""
    return select(stands, minimum(r, distance), r)


@inline
def _look_at_box(nodes, child, views, clear):
    """Return (distance, clear): that of a box from the nearest triangle which has to look into it, below 0 if none has.

    To triangles far from it in comparison with its size, a box is as good as what is in it.
    """
    x0, x1 = scalar(nodes, child + NODE.lo_x), scalar(nodes, child + NODE.hi_x)
    y0, y1 = scalar(nodes, child + NODE.lo_y), scalar(nodes, child + NODE.hi_y)
    z0, z1 = scalar(nodes, child + NODE.lo_z), scalar(nodes, child + NODE.hi_z)
    n, corner, half = views.normal, views.corner, np.float32(0.5)
    center = vector3(half * (x0 + x1), half * (y0 + y1), half * (z0 + z1)) - corner
    height = fma(absolute(n.x), half * (x1 - x0), fma(absolute(n.y), half * (y1 - y0),
                                                     fma(absolute(n.z), half * (z1 - z0), dot(n, center))))
    height = height - views.lift
    x, y = _gap(views.low.x, views.high.x, x0, x1), _gap(views.low.y, views.high.y, y0, y1)
    z = _gap(views.low.z, views.high.z, z0, z1)
    distance = sqrt(x * x + y * y + z * z)
    s0, s1 = (height > _S0 * distance) & (distance < clear.r0), (height > _S1 * distance) & (distance < clear.r1)
    s2, s3 = (height > _S2 * distance) & (distance < clear.r2), (height > _S3 * distance) & (distance < clear.r3)
    matters, nearest = s0 | s1 | s2 | s3, np.float32(-1)
    if any_lane(matters):
        small = distance * _COARSE > (x1 - x0) + (y1 - y0) + (z1 - z0)
        clear = _Clear(_less(clear.r0, s0 & small, distance), _less(clear.r1, s1 & small, distance),
                       _less(clear.r2, s2 & small, distance), _less(clear.r3, s3 & small, distance))
        matters = matters & ~small
        if any_lane(matters):
            nearest = lowest(select(matters, distance, _ENDLESS))
    return nearest, clear


@inline
def _corner_at(words, at, views):
    """Return a corner of a triangle of a leaf block, relative to that of triangles that look at it."""
    return vector3(scalar(words, at), scalar(words, at + _AXIS), scalar(words, at + 2 * _AXIS)) - views.corner


@inline
def _below(tangent, heights, along):
    """Return the lanes where three corners, and so what is between them, are not above an elevation.

    Heights over a triangle's plane, and how far each is along a direction in the plane from where the triangle ends
    there: nothing of it is nearer than that, measured level.
    """
    return (heights[0] <= tangent * along[0]) & (heights[1] <= tangent * along[1]) & (heights[2] <= tangent * along[2])


@inline
def _above(tangent, heights, a, b, c, d):
    """Return the lanes where that cannot be told along any of four directions."""
    return ~(_below(tangent, heights, a) | _below(tangent, heights, b) | _below(tangent, heights, c)
             | _below(tangent, heights, d))


@inline
def _along(out, views, pa, pb, pc):
    """Return how far three corners are along a direction from where triangles end there."""
    reach = maximum(0.0, maximum(dot(out, views.edge1), dot(out, views.edge2)))
    return dot(out, pa) - reach, dot(out, pb) - reach, dot(out, pc) - reach


@inline
def _least(three):
    """Return the least of three."""
    return minimum(three[0], minimum(three[1], three[2]))


@inline
def _look_at(words, at, nearest, others, views, clear):
    """Return how far triangles see nothing, now that one more triangle has been looked at; `others`: lanes to do so.

    It is below an elevation if it is when measured along one of five directions: towards it, out of each side, and up
    its own slope, which tells exactly how a triangle stands on a common corner.
    """
    pa, pb, pc = (_corner_at(words, at, views), _corner_at(words, at + _CORNER, views),
                  _corner_at(words, at + 2 * _CORNER, views))
    n = views.normal
    ha, hb, hc = dot(n, pa) - views.lift, dot(n, pb) - views.lift, dot(n, pc) - views.lift
    others = others & (maximum(ha, maximum(hb, hc)) > 0.0)
    if not any_lane(others):
        return clear
    heights, towards = (ha, hb, hc), (pa + pb + pc) - views.edge1 - views.edge2
    a = _along(_part_of(towards - n * dot(n, towards), towards), views, pa, pb, pc)
    s0 = others & ~_below(_T0, heights, a)
    if not any_lane(s0):
        return clear
    facing = cross(pb - pa, pc - pa)
    tilt = dot(n, facing)
    uphill = _part_of(n * tilt - facing, facing) * select(tilt < 0.0, f32(-1.0), 1.0)
    b = _along(uphill, views, pa, pb, pc)
    c, d = _along(views.out_a, views, pa, pb, pc), _along(views.out_b, views, pa, pb, pc)
    e = _along(views.out_c, views, pa, pb, pc)
    distance = maximum(maximum(maximum(_least(a), _least(b)), maximum(_least(c), _least(d))),
                       maximum(_least(e), nearest))
    s0 = s0 & _above(_T0, heights, b, c, d, e)  # what is below one elevation is below the steeper ones
    s1 = s0 & ~_below(_T1, heights, a) & _above(_T1, heights, b, c, d, e)
    s2 = s1 & ~_below(_T2, heights, a) & _above(_T2, heights, b, c, d, e)
    s3 = s2 & ~_below(_T3, heights, a) & _above(_T3, heights, b, c, d, e)
    return _Clear(_less(clear.r0, s0, distance), _less(clear.r1, s1, distance), _less(clear.r2, s2, distance),
                  _less(clear.r3, s3, distance))


@routine
def _look_around(nodes, blocks, root, views, prims):
    """Return the _Clear of triangles, the nearest boxes first."""
    codes, distances = stack_ints(STACK_SIZE), stack_floats(STACK_SIZE)
    farthest = select(views.sound, f32(_ENDLESS), 0.0)
    clear = _Clear(farthest, farthest, farthest, farthest)
    size, code, near = 0, np.int32(root), np.float32(0)
    while True:
        if code >= 0:
            base, bottom = np.int64(code) * NODE.words, size
            for k in range(8):
                if scalar(nodes, base + k) > scalar(nodes, base + NODE.hi_x + k):
                    continue
                distance, clear = _look_at_box(nodes, base + k, views, clear)
                if distance < 0:
                    continue
                place = size
                while place > bottom and distances[place - 1] < distance:
                    distances[place], codes[place] = distances[place - 1], codes[place - 1]
                    place -= 1
                distances[place], codes[place] = distance, scalar_int(nodes, base + NODE.child + k)
                size += 1
        else:
            base = np.int64(~code // LEAF_STEP) * TRIANGLE_BLOCK.words
            for j in range(~code % LEAF_STEP):
                others = prims != scalar_int(blocks, base + TRIANGLE_BLOCK.prim + j)
                clear = _look_at(blocks, base + j, near, others, views, clear)
        while True:
            if size == 0:
                return clear
            size -= 1
            code, near = codes[size], distances[size]
            if any_lane(near < clear.r3):
                break


@inline
def _byte(r, per_unit):
    """Return a distance as a byte, 2**(byte / 8) - 1 units or less; 255 means endless."""
    scaled = minimum(r * per_unit * _SHORTER, np.float32(2.0**31)) + 1.0
    code = (as_int(scaled) - CLEAR_BIAS) >> CLEAR_SHIFT
    return select(r < _ENDLESS, minimum(code, 254), 255)


@kernel
def find_clearances(nodes, blocks, root, first, end, shift, side, lift, per_unit, faces):
    """Write the clearances of the triangles in some leaf blocks of a mesh.

    Parameters
    ----------
    nodes, blocks : float32
        NODE and TRIANGLE_BLOCK records, those of the mesh among them.
    root : int
        Child code of the mesh's tree.
    first, end : int
        The first block, and the one after the last.
    shift : int
        Where the mesh's triangles begin in `faces`.
    side : float32
        1 to look from where triangles run counter-clockwise, -1 from the other side.
    lift, per_unit : float32
        The height above a triangle from which its rays start at the least, and 1 / the unit of distances.
    faces : int32
    """
    nodes_, blocks_, target = pointer(nodes), pointer(blocks), pointer(faces)
    planes, words = stack_floats(_PLANES), stack_ints(LANES)
    for group in range(first, end, _GROUP):
        for k in range(_GROUP):
            base = min(group + k, end - 1) * TRIANGLE_BLOCK.words
            for plane in range(10):
                store(planes, LANES * plane + LEAF_SIZE * k, load4(blocks_, base + plane * LEAF_SIZE))
        views, prims = _views(planes, side, lift), load_int(planes, 9 * LANES)
        clear = _look_around(nodes_, blocks_, root, views, prims)
        store(words, 0, _byte(clear.r0, per_unit) | (_byte(clear.r1, per_unit) << np.int32(8))
              | (_byte(clear.r2, per_unit) << np.int32(16)) | (_byte(clear.r3, per_unit) << np.int32(24)))
        for lane in range(LANES):
            prim = scalar_int(planes, 9 * LANES + lane)
            if prim >= 0:
                store_scalar(target, FACE.words * (shift + prim) + FACE.clearance, scalar_int(words, lane))
