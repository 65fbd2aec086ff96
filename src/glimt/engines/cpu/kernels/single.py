"""One ray after the other down a mesh's tree: for packets whose rays go every way.

A ray meets eight boxes at once, or four triangles at once, by the same operations in the same order as in a packet: its
hit is the same to the bit.
"""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.hit import DONE, Hit
from glimt.engines.cpu.kernels.stack import push_sorted
from glimt.engines.cpu.kernels.triangle import within
from glimt.kernel import inline
from glimt.lanes import (
    bits,
    count_trailing_zeros,
    difference,
    extract,
    fma,
    load,
    load4,
    load8,
    load_int,
    maximum,
    minimum,
    product,
    reciprocal,
    scalar,
    scalar_int,
    stack_floats,
    stack_ints,
    store,
    store8,
    store_scalar,
)
from glimt.layout import BOTH_X, BOTH_Y, BOTH_Z, BOX_SLACK, LEAF_SIZE, LEAF_STEP, NODE, TRIANGLE_BLOCK

_AXIS = np.int64(LEAF_SIZE)
_CORNER = np.int64(3 * LEAF_SIZE)


class Ray(NamedTuple):
    """One lane of `packet.Rays`: scalars."""

    near_x: object
    near_y: object
    near_z: object
    inverse_x: object
    inverse_y: object
    inverse_z: object
    near_add_x: object
    near_add_y: object
    near_add_z: object
    far_add_x: object
    far_add_y: object
    far_add_z: object
    axis_x: object
    axis_y: object
    axis_z: object
    origin_x: object
    origin_y: object
    origin_z: object
    shear_x: object
    shear_y: object
    shear_z: object


@inline
def _near(inverse, lo_plane, hi_plane):
    return lo_plane if inverse >= 0 else hi_plane


@inline
def _ray(rays, lane):
    """Return one ray of a packet."""
    x, y, z = extract(rays.inverse.x, lane), extract(rays.inverse.y, lane), extract(rays.inverse.z, lane)
    axis = 2
    if extract(rays.longest_x, lane):
        axis = 0
    elif extract(rays.longest_y, lane):
        axis = 1
    return Ray(_near(x, NODE.lo_x, NODE.hi_x), _near(y, NODE.lo_y, NODE.hi_y), _near(z, NODE.lo_z, NODE.hi_z), x, y, z,
               extract(rays.near_add.x, lane), extract(rays.near_add.y, lane), extract(rays.near_add.z, lane),
               extract(rays.far_add.x, lane), extract(rays.far_add.y, lane), extract(rays.far_add.z, lane),
               ((axis + 1) % 3) * _AXIS, ((axis + 2) % 3) * _AXIS, axis * _AXIS,
               extract(rays.shear_origin.x, lane), extract(rays.shear_origin.y, lane),
               extract(rays.shear_origin.z, lane),
               extract(rays.shear.x, lane), extract(rays.shear.y, lane), extract(rays.shear.z, lane))


@inline
def _children(nodes, base, ray, t):
    """Return (entry, exit) of the ray for the eight children of a node."""
    entry = maximum(maximum(fma(load8(nodes, base + ray.near_x), ray.inverse_x, ray.near_add_x),
                            fma(load8(nodes, base + ray.near_y), ray.inverse_y, ray.near_add_y)),
                    maximum(fma(load8(nodes, base + ray.near_z), ray.inverse_z, ray.near_add_z), 0.0))
    leave = minimum(minimum(fma(load8(nodes, base + BOTH_X - ray.near_x), ray.inverse_x, ray.far_add_x),
                            fma(load8(nodes, base + BOTH_Y - ray.near_y), ray.inverse_y, ray.far_add_y)),
                    minimum(fma(load8(nodes, base + BOTH_Z - ray.near_z), ray.inverse_z, ray.far_add_z), t))
    return entry, leave * BOX_SLACK


@inline
def _corners(words, at, ray):
    """Return (x, y, z) of the same corner of four triangles as `triangle._corner` does."""
    z = load4(words, at + ray.axis_z) - ray.origin_z
    return (fma(-ray.shear_x, z, load4(words, at + ray.axis_x) - ray.origin_x),
            fma(-ray.shear_y, z, load4(words, at + ray.axis_y) - ray.origin_y), z)


@inline
def _edge(px, py, qx, qy):
    return difference(product(px, qy), product(py, qx))


@inline
def _leaf(scene, inst, code, ray, t, u, v, prim, hit_inst, occlusion):
    """Test up to four triangles at once (see `triangle.triangle_leaf`); return (t, u, v, prim, inst)."""
    words = scene.blas_blocks
    base = np.int64(code // LEAF_STEP) * TRIANGLE_BLOCK.words
    ax, ay, az = _corners(words, base, ray)
    bx, by, bz = _corners(words, base + _CORNER, ray)
    cx, cy, cz = _corners(words, base + 2 * _CORNER, ray)
    wa, wb, wc = _edge(cx, cy, bx, by), _edge(ax, ay, cx, cy), _edge(bx, by, ax, ay)
    inside = bits((minimum(wa, minimum(wb, wc)) >= 0.0) | (maximum(wa, maximum(wb, wc)) <= 0.0))
    inside &= (1 << (code % LEAF_STEP)) - 1
    if inside:
        inside &= bits(within(ax, bx, cx) & within(ay, by, cy))
        scale = reciprocal(wa + wb + wc)
        us, vs = wb * scale, wc * scale
        ts = fma(wa * scale, az, fma(us, bz, vs * cz)) * ray.shear_z
        while inside:
            j = count_trailing_zeros(inside)
            inside &= inside - 1
            this, id_ = extract(ts, j), scalar_int(words, base + TRIANGLE_BLOCK.prim + j)
            before = hit_inst > inst or (hit_inst == inst and prim > id_)
            if this > 0 and (this < t or (this == t and before)):
                if occlusion:
                    return DONE, u, v, prim, hit_inst
                t, u, v, prim, hit_inst = this, extract(us, j), extract(vs, j), id_, np.int32(inst)
    return t, u, v, prim, hit_inst


@inline
def _walk(scene, root, inst, ray, t, u, v, prim, hit_inst, occlusion):
    """Walk one ray down a tree, nearest children first; return (t, u, v, prim, inst)."""
    nodes = scene.blas_nodes
    stack, distances, entries = stack_ints(512), stack_floats(512), stack_floats(8)
    code, size = np.int32(root), 0
    while True:
        if code >= 0:
            base = np.int64(code) * NODE.words
            entry, leave = _children(nodes, base, ray, t)
            found = bits(entry <= leave)
            store8(entries, 0, entry)
            bottom = size
            while found:
                k = np.int64(count_trailing_zeros(found))
                found &= found - 1
                push_sorted(stack, distances, bottom, size, scalar(entries, k),
                            scalar_int(nodes, base + NODE.child + k))
                size += 1
        else:
            t, u, v, prim, hit_inst = _leaf(scene, inst, ~code, ray, t, u, v, prim, hit_inst, occlusion)
            if occlusion and t < 0:
                return t, u, v, prim, hit_inst
        while True:
            if size == 0:
                return t, u, v, prim, hit_inst
            size -= 1
            if scalar(distances, size) <= t * BOX_SLACK:
                code = scalar_int(stack, size)
                break


@inline
def walk_each(scene, root, rays, hit, lanes, occlusion, inst):
    """Walk each ray of a packet, of those in the bits of `lanes`, that still looks for something."""
    ts, us, vs, prims, insts = (stack_floats(16), stack_floats(16), stack_floats(16), stack_ints(16), stack_ints(16))
    store(ts, 0, hit.t)
    store(us, 0, hit.u)
    store(vs, 0, hit.v)
    store(prims, 0, hit.prim)
    store(insts, 0, hit.inst)
    todo = bits(hit.t > 0.0) & lanes
    while todo:
        lane = count_trailing_zeros(todo)
        todo &= todo - 1
        t, u, v, prim, hit_inst = _walk(scene, root, inst, _ray(rays, lane), scalar(ts, lane), scalar(us, lane),
                                        scalar(vs, lane), scalar_int(prims, lane), scalar_int(insts, lane), occlusion)
        store_scalar(ts, lane, t)
        store_scalar(us, lane, u)
        store_scalar(vs, lane, v)
        store_scalar(prims, lane, prim)
        store_scalar(insts, lane, hit_inst)
    return Hit(load(ts, 0), load(us, 0), load(vs, 0), load_int(prims, 0), load_int(insts, 0))
