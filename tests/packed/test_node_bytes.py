"""What a ray reads on its way down the trees of real meshes, with nodes of three makes around the same leaves."""

import numpy as np
import pytest

import glimt
from glimt import linalg
from glimt.bvh import subtrees
from glimt.bvh.build import _Builder
from glimt.bvh.wide import RECORD
from glimt.layout import COMPRESSED_NODE, LEAF_STEP, NODE, TRIANGLE_BLOCK
from glimt.packed import pack
from glimt.packed.compressed_nodes import compress
from glimt.packed.meshes import _boxes
from tree_walk import Children, block_corners, compressed_children, triangle_leaf, walk, wide_children

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
    boxes = work.binary.reshape(-1, RECORD)[:, :8].astype(np.float64)
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
    return Children(boxes[pairs, :3].transpose(0, 2, 1), -boxes[pairs, 4:7].transpose(0, 2, 1),
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


@pytest.mark.parametrize("name", ["stanford_bunny/stanford-bunny.obj", "meshes/igea.ply"])
def test_a_ray_reads_less_than_in_a_plain_binary_tree(real_scenes, name):
    path = real_scenes / name
    if not path.exists():
        pytest.skip(f"no {path}")
    mesh = load(path)
    packed = pack(glimt.Scene().add(mesh))
    trees = compress(packed)
    pairs, prims = binary_children(mesh)
    compressed, corners = compressed_children(trees.blas_nodes), block_corners(trees.blas_blocks)
    makes = {
        "binary": (pairs, mesh.positions[mesh.triangles[prims]].astype(np.float64), PAIR_BYTES, False),
        "wide": (wide_children(packed.blas_nodes), block_corners(packed.blas_blocks), 4 * NODE.words, False),
        "compressed": (compressed, corners, 4 * COMPRESSED_NODE.words, False),
        "by octant": (compressed, corners, 4 * COMPRESSED_NODE.words, True),
    }
    origins, directions = rays_at(mesh, np.random.default_rng(0), 1000)
    bytes_per_ray, found = {}, []
    for make, (children, corners, node_bytes, by_octant) in makes.items():
        t = np.full(len(origins), np.inf)
        nodes, leaves = walk(children, 0, origins, directions, t, triangle_leaf(corners, origins, directions, t),
                             by_octant)
        bytes_per_ray[make] = nodes.mean() * node_bytes + leaves.mean() * BLOCK_BYTES
        found.append(t)
    for t in found[1:]:
        np.testing.assert_allclose(t, found[0], rtol=1e-12)
    assert np.isfinite(found[0]).mean() > 0.4
    assert bytes_per_ray["compressed"] < 0.6 * bytes_per_ray["binary"]
    assert bytes_per_ray["compressed"] < 0.5 * bytes_per_ray["wide"]
    assert bytes_per_ray["by octant"] < 0.8 * bytes_per_ray["binary"]
