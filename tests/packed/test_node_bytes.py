"""What a ray reads on its way down the trees of real meshes, with nodes of three makes around the same leaves."""

import numpy as np
import pytest

import glimt
from glimt.layout import COMPRESSED_NODE, NODE
from glimt.packed import pack
from glimt.packed.compressed_nodes import compress
from node_bytes import BLOCK_BYTES, MESHES, binary_bytes, load, rays_at, visits
from tree_walk import block_corners, compressed_children, wide_children


@pytest.mark.parametrize("name", MESHES)
def test_a_ray_reads_less_than_in_a_plain_binary_tree(real_scenes, name):
    path = real_scenes / name
    if not path.exists():
        pytest.skip(f"no {path}")
    mesh = load(path)
    packed = pack(glimt.Scene().add(mesh))
    trees = compress(packed)
    compressed, corners = compressed_children(trees.blas_nodes), block_corners(trees.blas_blocks)
    makes = {
        "wide": (wide_children(packed.blas_nodes), block_corners(packed.blas_blocks), 4 * NODE.words, False),
        "compressed": (compressed, corners, 4 * COMPRESSED_NODE.words, False),
        "by octant": (compressed, corners, 4 * COMPRESSED_NODE.words, True),
    }
    origins, directions = rays_at(mesh, np.random.default_rng(0), 1000)
    binary, found = binary_bytes(mesh, origins, directions)
    bytes_per_ray = {}
    for make, (children, own_corners, node_bytes, by_octant) in makes.items():
        nodes, leaves, t = visits(children, own_corners, origins, directions, by_octant)
        bytes_per_ray[make] = nodes.mean() * node_bytes + leaves.mean() * BLOCK_BYTES
        np.testing.assert_allclose(t, found, rtol=1e-12)
    assert np.isfinite(found).mean() > 0.4
    assert bytes_per_ray["compressed"] < 0.6 * binary
    assert bytes_per_ray["compressed"] < 0.5 * bytes_per_ray["wide"]
    assert bytes_per_ray["by octant"] < 0.8 * binary
