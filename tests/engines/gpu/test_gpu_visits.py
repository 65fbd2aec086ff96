"""What rays visit on the GPU: as much as on the CPU and as the trees say, and far less than in binary trees."""

import functools
import os
from unittest import mock

import numpy as np
import pytest
from both_engines import on_cpu, on_gpu, sized
from test_same_pictures import EXAMPLES

import glimt
from glimt.engines.gpu.engine import GpuEngine
from glimt.engines.gpu.pace import Pace
from glimt.engines.gpu.stages import counter_words
from glimt.layout import COMPRESSED_NODE, COUNTER
from glimt.packed import pack
from glimt.packed.compressed_nodes import compress
from node_bytes import BLOCK_BYTES, MESHES, binary_bytes, load, rays_at, visits
from tree_walk import block_corners, compressed_children

pytestmark = pytest.mark.usefixtures("software_gpu")


@functools.cache
def _counting():
    with mock.patch.dict(os.environ, GLIMT_GPU="software"):
        return GpuEngine(counting=True)


def _counts(visits_):
    """Return (nodes, blocks) of primary rays."""
    return np.array([visits_["nodes"][0], visits_["blocks"][0]])


@pytest.mark.parametrize("path", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_primary_rays_visit_what_they_visit_on_the_cpu(path):
    """Nodes and triangle blocks. The GPU's boxes are up to a cell larger, so that it visits more of them."""
    scene = sized(glimt.load(path), 64, 48, 1, 1)
    engine = _counting()
    gpu = on_gpu(scene, engine)
    gpu.render()
    counted, seen = _counts(engine.visits), gpu.render_debug("nodes").values[..., :2].sum((0, 1))
    np.testing.assert_array_equal(counted, seen)
    wanted = on_cpu(scene).render_debug("nodes").values[..., :2].sum((0, 1))
    assert ((counted >= 0.98 * wanted) & (counted <= 1.1 * wanted)).all(), counted / wanted


def test_each_kind_of_ray_has_its_own_counts():
    scene = sized(glimt.load(next(path for path in EXAMPLES if path.stem == "mirrors")), 64, 48, 2, 1)
    engine = _counting()
    whole = on_gpu(scene, engine).render()
    visited = engine.visits
    assert whole.counters.mirror > 0
    assert all((visited[name] > 0).all() for name in ("nodes", "blocks"))
    unlit = on_gpu(scene, engine)
    unlit.scene = sized(scene, 64, 48, 2, 0)
    unlit.scene.lights = []
    unlit.render()
    for name, counts in engine.visits.items():
        assert counts.tolist() == [visited[name][0], 0, 0]


@pytest.mark.parametrize("name", MESHES)
def test_a_ray_reads_what_the_trees_say_and_less_than_in_a_binary_tree(real_scenes, name):
    if not (real_scenes / name).exists():
        pytest.skip(f"no {real_scenes / name}")
    mesh, engine = load(real_scenes / name), _counting()
    scene = glimt.Scene().add(mesh)
    origins, directions = (part.astype(np.float32) for part in rays_at(mesh, np.random.default_rng(0), 1000))
    count = len(origins)
    on_gpu(scene, engine)._upload(0.0)
    engine._pace = Pace()  # whatever there was before, all rays go at once
    hits = engine.find_hits(np.concatenate([origins, directions, np.full((count, 1), np.inf, np.float32)], 1).T)
    counters = engine._download.read(engine._buffers["counters"], np.empty(counter_words(0), np.uint32))
    nodes, blocks = counters[COUNTER.nodes], counters[COUNTER.blocks]

    trees = compress(pack(scene))
    origins, directions = origins.astype(np.float64), directions.astype(np.float64)
    own_nodes, own_blocks, t = visits(compressed_children(trees.blas_nodes), block_corners(trees.blas_blocks), origins,
                                      directions)
    met = np.isfinite(t) & np.isfinite(hits.t)
    assert met.sum() > 0.4 * count
    np.testing.assert_allclose(hits.t[met], t[met], rtol=1e-4, atol=1e-6)
    assert nodes == pytest.approx(own_nodes.sum(), rel=0.03)
    assert blocks == pytest.approx(own_blocks.sum(), rel=0.03)
    binary, _ = binary_bytes(mesh, origins, directions)
    read = (nodes * 4 * COMPRESSED_NODE.words + blocks * BLOCK_BYTES) / count
    assert read < 0.6 * binary
