"""Real meshes, rays at them, and what those read on their way down trees of several makes."""

import numpy as np

import glimt
from glimt import linalg
from glimt.bvh import subtrees
from glimt.bvh.build import _Builder
from glimt.bvh.wide import RECORD
from glimt.layout import LEAF_STEP, TRIANGLE_BLOCK
from glimt.packed.meshes import _boxes
from tree_walk import Children, triangle_leaf, walk

MESHES = ["stanford_bunny/stanford-bunny.obj", "meshes/igea.ply"]
BLOCK_BYTES = 4 * TRIANGLE_BLOCK.words
PAIR_BYTES = 64  # two boxes, two child codes, padding


def binary_children(mesh):
    """Return the pairs of the binary tree that the builder collapses, and the primitives (b, 4) of its leaves."""
    lo, hi = _boxes(mesh)
    work = _Builder(lo, hi, 4, None, 0)
    opened, used = np.array([work.top]), 0
    while len(opened):
        tasks = np.zeros((len(opened), subtrees.TASK_WORDS), np.int64)
        tasks[:, subtrees.ROOT], tasks[:, subtrees.START] = opened, used + 2 * np.arange(len(opened))
        work._build(tasks, subtrees.SPLIT_ONCE)
        split = work.meta[opened, 1] < 0
        opened = (tasks[split, subtrees.START, None] + np.arange(2)).ravel()
        used += 2 * len(tasks)
    boxes = work.binary.reshape(-1, RECORD)[:, :8]
    lefts, counts = work.meta.T
    ids = work.boxes.reshape(-1, 8)[:, 3].view(np.int32) & ~subtrees.ID_TAG
    inner, leaves, prims, at = [work.top], 0, [], 0
    codes = []
    while at < len(inner):  # number pairs and leaves in the order in which they are met
        for child in lefts[inner[at]] + np.arange(2):
            if counts[child] < 0:
                codes.append(len(inner))
                inner.append(child)
            else:
                codes.append(~(leaves * int(LEAF_STEP) + int(counts[child])))
                prims.append(np.resize(ids[lefts[child]:lefts[child] + counts[child]], 4))
                leaves += 1
        at += 1
    pairs = lefts[inner][:, None] + np.arange(2)
    paired = boxes[pairs].astype(np.float64)  # others are of no use, or were never written
    return Children(paired[..., :3].transpose(0, 2, 1), -paired[..., 4:7].transpose(0, 2, 1),
                    np.array(codes).reshape(-1, 2)), np.array(prims)


def rays_at(mesh, random, count):
    """Return rays that go for points of a surface from around it, and as many that start beside it and go any way."""
    corners = mesh.positions[mesh.triangles[random.integers(len(mesh.triangles), size=count)]].astype(np.float64)
    points = np.einsum("nk,nka->na", random.dirichlet((1, 1, 1), count), corners)
    size, (away, along) = np.ptp(mesh.bounds()), linalg.normalize(random.normal(size=(2, count, 3)))
    origins = np.mean(mesh.bounds(), 0) + away * 2 * size
    return np.concatenate([origins, points + along * 1e-4 * size]), np.concatenate([points - origins, along])


def load(path):
    """Return the mesh of an OBJ file, or of a PLY file of one triangle strip."""
    if path.suffix == ".obj":
        return next(thing.mesh for thing in glimt.load(path).objects if isinstance(thing, glimt.Instance))
    header, body = path.read_bytes().split(b"end_header\n", 1)
    count = int(header.split(b"element vertex ")[1].split()[0])
    strip = np.frombuffer(body, np.int32, offset=12 * count)[1:]  # -1 begins another
    triangles = np.lib.stride_tricks.sliding_window_view(strip, 3)
    return glimt.Mesh(np.frombuffer(body, np.float32, 3 * count).reshape(-1, 3), triangles[(triangles >= 0).all(1)])


def binary_bytes(mesh, origins, directions):
    """Return how many bytes each ray reads in a plain binary tree on average, and where it hits."""
    pairs, prims = binary_children(mesh)
    nodes, leaves, t = visits(pairs, mesh.positions[mesh.triangles[prims]].astype(np.float64), origins, directions)
    return nodes.mean() * PAIR_BYTES + leaves.mean() * BLOCK_BYTES, t


def visits(children, corners, origins, directions, by_octant=False):
    """Return how many (nodes, leaves) each ray visits in a tree with the triangles of its blocks, and where it hits."""
    t = np.full(len(origins), np.inf)
    nodes, leaves = walk(children, 0, origins, directions, t, triangle_leaf(corners, origins, directions, t), by_octant)
    return nodes, leaves, t
