"""Rays down trees of any make, in float64, all rays side by side: what they reach and what they visit on the way."""

from typing import NamedTuple

import numpy as np

from glimt.layout import COMPRESSED_NODE, INNER_META, LEAF_META, LEAF_STEP, NODE, TRIANGLE_BLOCK, dtype

EMPTY = -1  # a leaf of nothing, ~0


class Children(NamedTuple):
    """Boxes (n, 3, k) and child codes (n, k) of the children of n nodes; `~(block * LEAF_STEP + count)` is a leaf."""

    lo: np.ndarray
    hi: np.ndarray
    codes: np.ndarray


def wide_children(words):
    """Return the children of NODE records."""
    nodes = words.view(dtype(NODE))
    lo, hi = (np.stack([nodes[f"{side}_{axis}"] for axis in "xyz"], 1).astype(np.float64) for side in ("lo", "hi"))
    return Children(lo, hi, nodes["child"])


def compressed_children(words):
    """Return the children of COMPRESSED_NODE records, decoded in float32 as layout.py says."""
    nodes = words.view(dtype(COMPRESSED_NODE))
    scales = nodes["exponents"].copy().view(np.int8).reshape(-1, 4)[:, :3]
    cells = np.ldexp(np.float32(1), scales.astype(int))[..., None]
    origin = nodes["origin"][..., None]
    lo, hi = (origin + _bytes(*(nodes[f"{side}_{axis}"] for axis in "xyz")).astype(np.float32) * cells
              for side in ("lo", "hi"))
    assert lo.dtype == hi.dtype == np.float32
    meta = _bytes(nodes["meta"])[:, 0].astype(np.int64)
    inner = (nodes["exponents"].view(np.uint32)[:, None] >> (24 + np.arange(8))) & 1 == 1
    np.testing.assert_array_equal(inner, meta & INNER_META != 0)
    leaf = meta & LEAF_META != 0
    assert not (inner & leaf).any()
    assert not meta[~inner & ~leaf].any()
    low = meta & 0x3f
    codes = np.where(inner, nodes["child_base"][:, None] + low,
                     np.where(leaf, ~(nodes["block_base"][:, None] * LEAF_STEP + low), EMPTY))
    return Children(lo.astype(np.float64), hi.astype(np.float64), codes)


def _bytes(*fields):
    return np.stack([np.ascontiguousarray(field).view(np.uint8).reshape(-1, 8) for field in fields], 1)


def walk(children, root, origins, directions, t, leaf, by_octant=False):
    """Walk rays down a tree and return how many (nodes, leaves) each has visited.

    `leaf(rays, blocks, counts)` may shorten some rays of `t`. Children are visited by distance, and looked at again
    when their turn comes; or in order of ``slot ^ octant``, without a second look.
    """
    rays = len(origins)
    codes, distances = np.full((rays, 256), root), np.zeros((rays, 256))
    size, nodes, leaves = np.ones(rays, int), np.zeros(rays, int), np.zeros(rays, int)
    octant = (directions < 0) @ (1, 2, 4)
    while (active := np.flatnonzero(size)).size:
        size[active] -= 1
        code, distance = codes[active, size[active]], distances[active, size[active]]
        near = distance <= t[active]
        active, code = active[near], code[near]
        is_leaf = code < 0
        leaves[active[is_leaf]] += 1
        leaf(active[is_leaf], ~code[is_leaf] // LEAF_STEP, ~code[is_leaf] % LEAF_STEP)
        active, code = active[~is_leaf], code[~is_leaf]
        nodes[active] += 1
        below = Children(*(part[code] for part in children))
        enter, leave = _slabs(below, origins[active], directions[active])
        met = (enter <= np.minimum(leave, t[active, None])) & (below.codes != EMPTY)
        slots = np.arange(below.codes.shape[1])
        order = np.argsort(octant[active, None] ^ slots if by_octant else enter, axis=1)[:, ::-1]
        for slot in order.T:
            here = met[np.arange(len(active)), slot]
            ray, slot = active[here], slot[here]
            codes[ray, size[ray]] = below.codes[here, slot]
            distances[ray, size[ray]] = 0 if by_octant else enter[here, slot]
            size[ray] += 1
    return nodes, leaves


def _slabs(below, origins, directions):
    """Return where rays with no direction component of 0 enter and leave boxes; inside-out ones are never met."""
    forward = directions[:, :, None] > 0
    first, last = np.where(forward, below.lo, below.hi), np.where(forward, below.hi, below.lo)
    enter = ((first - origins[..., None]) / directions[..., None]).max(1)
    return np.maximum(enter, 0), ((last - origins[..., None]) / directions[..., None]).min(1)


def block_corners(words):
    """Return the corners (b, 4, 3, 3) of TRIANGLE_BLOCK records."""
    rows = words.view(np.float32).reshape(-1, TRIANGLE_BLOCK.words)[:, :TRIANGLE_BLOCK.prim]
    return rows.reshape(-1, 3, 3, 4).transpose(0, 3, 1, 2).astype(np.float64)


def triangle_hits(corners, origins, directions):
    """Return t of rays (n, 3) that meet triangles (n, k, 3, 3), inf for the others: Möller and Trumbore's test."""
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    origins, directions = origins[:, None], directions[:, None]
    across = np.cross(directions, c - a)
    area = (across * (b - a)).sum(-1)
    scale = 1 / np.where(area == 0, np.nan, area)
    u, back = (across * (origins - a)).sum(-1) * scale, np.cross(origins - a, b - a)
    v, t = (back * directions).sum(-1) * scale, (back * (c - a)).sum(-1) * scale
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf)


def triangle_leaf(corners, origins, directions, t):
    """Return the `leaf` of `walk` that finds the closest triangle."""
    def leaf(rays, blocks, counts):
        hits = triangle_hits(corners[blocks], origins[rays], directions[rays])
        hits[np.arange(corners.shape[1]) >= counts[:, None]] = np.inf
        t[rays] = np.minimum(t[rays], hits.min(1, initial=np.inf))
    return leaf
