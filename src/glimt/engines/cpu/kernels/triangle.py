"""Triangles against a packet, watertight."""

import numpy as np

from glimt.engines.cpu.kernels.hit import block, closer, replace
from glimt.engines.cpu.kernels.packet import ANY_AXIS, other_axes, permute
from glimt.kernel import inline
from glimt.lanes import (
    LANES,
    any_lane,
    bits,
    count_trailing_zeros,
    difference,
    fma,
    from_bits,
    load3,
    maximum,
    minimum,
    product,
    reciprocal,
    scalar,
    scalar_int,
    stack_floats,
    stack_ints,
    store3,
    store_scalar,
    vector3,
)
from glimt.layout import LEAF_SIZE, LEAF_STEP, TRIANGLE_BLOCK

AXIS = np.int64(LEAF_SIZE)  # words from x to y and from y to z in a block
CORNER = np.int64(3 * LEAF_SIZE)
_SEEN, _DEPTHS = np.int64(6 * LANES), np.int64(3 * LANES)  # words of how a packet sees a triangle, and to its depths
_TRIANGLES, _SEEN_WORDS = int(LEAF_SIZE), 6 * LANES * int(LEAF_SIZE)


@inline
def sheared(turned, shears):
    """Return a corner that was turned as rays are, relative to their origin and sheared as they are."""
    p = turned - shears.shear_origin
    return vector3(fma(-shears.shear.x, p.z, p.x), fma(-shears.shear.y, p.z, p.y), p.z)


@inline
def _corner(words, at, shears):
    """Return a corner relative to the origin, turned and sheared so that the ray is the z axis; z not yet scaled."""
    if shears.axis == ANY_AXIS:
        turned = permute(shears.longest_x, shears.longest_y,
                         vector3(scalar(words, at), scalar(words, at + AXIS), scalar(words, at + 2 * AXIS)))
    else:
        x, y = other_axes(shears.axis)
        turned = vector3(scalar(words, at + x * AXIS), scalar(words, at + y * AXIS),
                         scalar(words, at + shears.axis * AXIS))
    return sheared(turned, shears)


@inline
def _edge(p, q):
    """Return p.x q.y - p.y q.x with a sign that is never wrong: rounding is monotonic, and nothing is fused."""
    return difference(product(p.x, q.y), product(p.y, q.x))


@inline
def edges(a, b, c):
    """Return the edge functions of corners seen along a ray, and the lanes where none is on another side than the rest.

    A packet has one triangle in all lanes, a ray has another in each.
    """
    wa, wb, wc = _edge(c, b), _edge(a, c), _edge(b, a)
    return wa, wb, wc, (minimum(wa, minimum(wb, wc)) >= 0.0) | (maximum(wa, maximum(wb, wc)) <= 0.0)


@inline
def within(a, b, c):
    """Return the lanes whose ray, which is at 0, passes between the least and the greatest coordinates of corners.

    Edge functions of a triangle far smaller than its distance from the ray round to 0, which counts as inside.
    """
    return ((minimum(a.x, minimum(b.x, c.x)) <= 0.0) & (maximum(a.x, maximum(b.x, c.x)) >= 0.0)
            & (minimum(a.y, minimum(b.y, c.y)) <= 0.0) & (maximum(a.y, maximum(b.y, c.y)) >= 0.0))


@inline
def meeting(wa, wb, wc, za, zb, zc, shear_z):
    """Return (t, u, v) of where a ray meets the plane of a triangle, by edge functions and the z of its corners."""
    scale = reciprocal(wa + wb + wc)  # NaN for an edge-on triangle, which then is not closer
    u, v = wb * scale, wc * scale
    return fma(wa * scale, za, fma(u, zb, v * zc)) * shear_z, u, v


@inline
def _corners(words, at, shears):
    return (_corner(words, at, shears), _corner(words, at + CORNER, shears), _corner(words, at + 2 * CORNER, shears))


@inline
def _see(words, base, count, shears, looking, seen, insides):
    """Write how a packet sees the triangles of a leaf block: edge functions, z of corners, and which rays are inside.

    Return the triangles that have any, as bits.
    """
    met = np.int32(0)
    for j in range(count):
        a, b, c = _corners(words, base + j, shears)
        wa, wb, wc, between = edges(a, b, c)
        store3(seen, j * _SEEN, LANES, vector3(wa, wb, wc))
        store3(seen, j * _SEEN + _DEPTHS, LANES, vector3(a.z, b.z, c.z))
        inside = bits(between & looking)
        store_scalar(insides, j, inside)
        met |= np.int32(inside != 0) << np.int32(j)
    return met


@inline
def triangle_leaf(scene, inst, code, shears, hit, occlusion):
    """Test the triangles of a leaf block.

    Woop, Benthin, Wald (2013). What differs: no second try in double precision; a ray on an edge counts as inside both
    triangles instead, and both sides of a triangle are hit. Neighbours compute their common edge from the same two
    projected corners, so no ray passes between them.

    Whether any ray is inside of a triangle no processor can foresee. So all are looked at before the first branch on
    that: then the answers are there, and a wrong guess has cost little.
    """
    words, base = scene.blas_blocks, np.int64(code // LEAF_STEP) * TRIANGLE_BLOCK.words
    seen, insides = stack_floats(_SEEN_WORDS), stack_ints(_TRIANGLES)
    met = _see(words, base, code % LEAF_STEP, shears, hit.t > 0.0, seen, insides)
    while met:
        j = np.int64(count_trailing_zeros(met))
        met &= met - 1
        inside, w = from_bits(scalar_int(insides, j)), load3(seen, j * _SEEN, LANES)
        if any_lane(inside & ((w.x == 0.0) | (w.y == 0.0) | (w.z == 0.0))):  # else they are within by the signs alone
            inside = inside & within(*_corners(words, base + j, shears))
        z = load3(seen, j * _SEEN + _DEPTHS, LANES)
        t, u, v = meeting(w.x, w.y, w.z, z.x, z.y, z.z, shears.shear.z)
        if occlusion:
            hit = block(hit, inside & (t > 0.0) & (t < hit.t), np.int32(code), inst)
        else:
            prim = scalar_int(words, base + TRIANGLE_BLOCK.prim + j)
            hit = replace(hit, closer(scene, hit, t, inst, prim, inside), t, u, v, prim, inst)
    return hit
