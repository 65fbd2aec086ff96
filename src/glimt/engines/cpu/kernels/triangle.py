"""Triangles against a packet, watertight."""

import numpy as np

from glimt.engines.cpu.kernels.hit import block, closer, replace
from glimt.engines.cpu.kernels.packet import ANY_AXIS, other_axes, permute
from glimt.kernel import inline
from glimt.lanes import any_lane, difference, fma, maximum, minimum, product, reciprocal, scalar, scalar_int, vector3
from glimt.layout import LEAF_SIZE, LEAF_STEP, TRIANGLE_BLOCK

AXIS = np.int64(LEAF_SIZE)  # words from x to y and from y to z in a block
CORNER = np.int64(3 * LEAF_SIZE)


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
def _within(a, b, c):
    """Return the lanes whose ray, which is at 0, passes between the least and the greatest of three coordinates.

    Edge functions of a triangle far smaller than its distance from the ray round to 0, which counts as inside.
    """
    return (minimum(a, minimum(b, c)) <= 0.0) & (maximum(a, maximum(b, c)) >= 0.0)


@inline
def meeting(a, b, c, wa, wb, wc, shear_z):
    """Return (t, u, v) of where a ray meets the plane of a triangle, and the lanes where that can be inside."""
    scale = reciprocal(wa + wb + wc)  # NaN for an edge-on triangle, which then is not closer
    u, v = wb * scale, wc * scale
    t = fma(wa * scale, a.z, fma(u, b.z, v * c.z)) * shear_z
    return t, u, v, _within(a.x, b.x, c.x) & _within(a.y, b.y, c.y)


@inline
def triangle_leaf(scene, inst, code, shears, hit, occlusion):
    """Test the triangles of a leaf block.

    Woop, Benthin, Wald (2013). What differs: no second try in double precision; a ray on an edge counts as inside both
    triangles instead, and both sides of a triangle are hit. Neighbours compute their common edge from the same two
    projected corners, so no ray passes between them.
    """
    words = scene.blas_blocks
    base = np.int64(code // LEAF_STEP) * TRIANGLE_BLOCK.words
    for j in range(code % LEAF_STEP):
        a = _corner(words, base + j, shears)
        b = _corner(words, base + CORNER + j, shears)
        c = _corner(words, base + 2 * CORNER + j, shears)
        wa, wb, wc, inside = edges(a, b, c)
        inside = inside & (hit.t > 0.0)
        if any_lane(inside):
            t, u, v, near = meeting(a, b, c, wa, wb, wc, shears.shear.z)
            inside = inside & near
            prim = scalar_int(words, base + TRIANGLE_BLOCK.prim + j)
            if occlusion:
                hit = block(hit, inside & (t > 0.0) & (t < hit.t), np.int32(code), inst)
            else:
                hit = replace(hit, closer(scene, hit, t, inst, prim, inside), t, u, v, prim, inst)
    return hit
