"""Compressed nodes: no box shrinks, nothing is lost or found twice, and rays find what they found before."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import glimt
import strategies
from glimt import Instance, Scene, Sphere, linalg
from glimt.layout import (
    COMPRESSED_NODE,
    INSTANCE,
    INSTANCE_BLOCK,
    LEAF_STEP,
    NODE,
    SPHERE_KIND,
    TRIANGLE_BLOCK,
    dtype,
)
from glimt.packed import Packer, pack
from glimt.packed.compressed_nodes import compress, compress_tree
from tree_walk import (
    EMPTY,
    block_corners,
    compressed_children,
    triangle_hits,
    triangle_leaf,
    walk,
    wide_children,
)

TINIEST = np.float32(2.0**-149)

# ---- boxes --------------------------------------------------------------------------------------------------------

coordinates = st.floats(-(2.0**119), 2.0**119, width=32)
boxes = st.tuples(coordinates, coordinates)


def node_of(lo, hi):
    """Return a NODE whose first children are leaves with boxes (k, 3); the others have NaN for a box."""
    node = np.zeros(1, dtype(NODE))
    for axis, name in enumerate("xyz"):
        node[f"lo_{name}"], node[f"hi_{name}"] = np.nan, np.nan
        node[f"lo_{name}"][0, :len(lo)], node[f"hi_{name}"][0, :len(lo)] = lo[:, axis], hi[:, axis]
    node["child"] = EMPTY
    node["child"][0, :len(lo)] = ~(np.arange(len(lo)) * LEAF_STEP + 1)
    return node.view(np.float32)


def check_boxes(lo, hi):
    """Compress one node and compare each child with its box."""
    tree = compress_tree(node_of(lo, hi), np.zeros(1, np.int32))
    record = tree.nodes.view(dtype(COMPRESSED_NODE))[0]
    decoded = compressed_children(tree.nodes)
    low, high, codes = decoded.lo[0].T, decoded.hi[0].T, decoded.codes[0]
    used = codes != EMPTY
    assert used.sum() == len(lo)
    lo, hi = lo[tree.blocks].astype(np.float64), hi[tree.blocks].astype(np.float64)
    low, high, empty_low, empty_high = low[used], high[used], low[~used], high[~used]
    assert (low <= lo).all()
    assert (high >= hi).all()
    assert (empty_low > empty_high).all()
    planes = np.abs(np.concatenate([low, high, empty_low, empty_high, record["origin"][None]]))
    assert ((planes == 0) | (planes >= 2.0**-126)).all()
    # No wider than a cell and what float32 rounds off; a cell is no larger than it must be.
    cell = 2.0**record["exponents"][None].view(np.int8)[:3].astype(float)
    rounding = np.spacing(np.abs(np.concatenate([low, high, record["origin"][None]])).max(0).astype(np.float32))
    assert (lo - low <= cell + rounding).all()
    assert (high - hi <= cell + rounding).all()
    coarse = cell > np.maximum(2.0**-126, np.spacing(np.abs(record["origin"])))
    extent = hi.max(0) - record["origin"]
    assert (extent[coarse] * 2.001 >= 255 * cell[coarse])[extent[coarse] > 0].all()


@given(st.lists(st.tuples(boxes, boxes, boxes), min_size=1, max_size=8))
@example([((1.0, 1.0), (0.0, 0.0), (-1e15, -1e15))])
@example([((float(TINIEST), float(TINIEST)), (-float(TINIEST), 0.0), (0.0, 2.0**-126))])
@example([((-(2.0**50), 0.0), (-(2.0**50), -1e-20), (0.0, 1.0)), ((-1e-20, 1e-20), (-1e-20, 1e-20), (0.5, 0.5))])
@example([((1.0, float(np.nextafter(np.float32(1), np.float32(2)))), (255.0, 510.0), (0.0, 255.0))])
def test_no_box_of_any_numbers_shrinks(children):
    sides = np.sort(np.array(children, np.float32), 2)
    check_boxes(sides[..., 0], sides[..., 1])


@given(strategies.seeds, st.integers(1, 8), st.integers(-44, 34), st.integers(-44, 34))
def test_no_box_of_any_scale_shrinks(seed, count, place, size):
    random = np.random.default_rng(seed)
    center = random.normal(size=(1, 3)) * 10.0**place + random.uniform(-1, 1, (count, 3)) * 10.0**size
    half = random.uniform(0, 1, (count, 3)) * random.choice([0, 1, 1e-3], (count, 3)) * 10.0**size
    check_boxes((center - half).astype(np.float32), (center + half).astype(np.float32))


# ---- trees --------------------------------------------------------------------------------------------------------

def reached(children, roots):
    """Return the leaf codes under each root, and the deepest level; fail when a node is met twice."""
    leaves, deepest, met = [], 0, []
    for root in roots:
        level, depth, found = np.array([root]), 0, []
        while len(level):
            met.append(level)
            codes = children.codes[level]
            found.append(codes[(codes < 0) & (codes != EMPTY)])
            level, depth = codes[codes >= 0], depth + 1
        leaves.append(np.concatenate(found))
        deepest = max(deepest, depth)
    met = np.concatenate(met) if met else np.empty(0, int)
    assert len(np.unique(met)) == len(met)
    return leaves, deepest


def check_links(words, trees):
    """Children and blocks lie side by side in slot order, and fill the arrays."""
    codes = compressed_children(words).codes[:None if trees else 0]  # without trees there is a node never read
    np.testing.assert_array_equal(codes[codes >= 0], np.arange(trees, len(codes)))
    blocks = ~codes[(codes < 0) & (codes != EMPTY)] // LEAF_STEP
    np.testing.assert_array_equal(blocks, np.arange(len(blocks)))


def prims_of(words, codes):
    """Return the primitives of leaves."""
    prims = words.view(np.int32).reshape(-1, TRIANGLE_BLOCK.words)[:, TRIANGLE_BLOCK.prim:]
    codes = ~codes.astype(int)
    return prims[codes // LEAF_STEP][np.arange(4) < (codes % LEAF_STEP)[:, None]]


def check_scene(scene):
    """Compare what is in the trees of a packed scene with what is in the compressed ones."""
    packed = pack(scene)
    trees = compress(packed)
    for name, words in (("blas_nodes", COMPRESSED_NODE.words), ("tlas_nodes", COMPRESSED_NODE.words),
                        ("blas_blocks", TRIANGLE_BLOCK.words), ("tlas_instances", 1)):
        assert len(getattr(trees, name)) >= words
        assert len(getattr(trees, name)) % words == 0
    records = packed.instances.view(dtype(INSTANCE))[:len(scene.objects)]
    is_mesh = records["kind"] != SPHERE_KIND
    np.testing.assert_array_equal(trees.roots[:len(records)] >= 0, is_mesh)
    check_links(trees.tlas_nodes, 1)
    above, trees_depth = reached(compressed_children(trees.tlas_nodes), [0])
    assert sorted(trees.tlas_instances[~above[0] // LEAF_STEP]) == list(range(len(records)))
    assert trees_depth == trees.tlas_depth
    roots = np.unique(trees.roots[:len(records)][is_mesh])
    old_roots = [records["root"][trees.roots[:len(records)] == root] for root in roots]
    assert all(len(set(old)) == 1 for old in old_roots)
    check_links(trees.blas_nodes, len(roots))
    new, depth = reached(compressed_children(trees.blas_nodes), roots)
    old, _ = reached(wide_children(packed.blas_nodes), [each[0] for each in old_roots])
    assert depth == trees.blas_depth or not len(roots)
    for after, before in zip(new, old, strict=True):
        prims = np.sort(prims_of(trees.blas_blocks, after))
        np.testing.assert_array_equal(prims, np.arange(len(prims)))
        np.testing.assert_array_equal(prims, np.sort(prims_of(packed.blas_blocks, before)))
    return packed, trees


@given(strategies.scenes())
def test_any_scene_keeps_what_it_has(scene):
    check_scene(scene)


SCENES = {
    "empty": Scene(),
    "spheres": Scene().add(Sphere((0, 0, 0), 1), Sphere((3, 0, 0), 1)),
    "empty mesh": Scene().add(glimt.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))),
    "one triangle": Scene().add(strategies.mesh_of(np.eye(3)[None])),
    "many instances": Scene().add(*[Instance(mesh, linalg.translation((k % 10, k // 10 % 10, k // 100)))
                                    for k, mesh in enumerate([strategies.mesh_of(np.eye(3)[None] / 2),
                                                              strategies.mesh_of(np.eye(3)[None] / 3)] * 500)]),
}


@pytest.mark.parametrize("name", ["spheres", "one triangle", "many instances"])
def test_a_scene_keeps_what_it_has(name):
    check_scene(SCENES[name])


@pytest.mark.parametrize("name", ["empty", "empty mesh"])
def test_a_scene_of_nothing(name):
    trees = compress(pack(SCENES[name]))
    assert (compressed_children(trees.tlas_nodes).codes == EMPTY).all()
    assert (compressed_children(trees.blas_nodes).codes == EMPTY).all()
    assert [len(array) for array in trees[:5]] == [COMPRESSED_NODE.words, TRIANGLE_BLOCK.words, COMPRESSED_NODE.words,
                                                   0, 1]
    assert trees.roots[0] == -1


def test_meshes_are_taken_over_when_instances_move():
    random = np.random.default_rng(0)
    meshes = [strategies.mesh_of(strategies.MESHES[name](random)) for name in strategies.MESHES]
    packer = Packer()
    scene = Scene().add(*[Instance(mesh, linalg.translation((3 * k, 0, 0))) for k, mesh in enumerate(meshes)])
    first = packer.pack(scene)
    before = compress(first)
    for k, thing in enumerate(scene.objects):
        thing.object_to_world = linalg.translation((0, -5 * k**2, 0))
    second = packer.pack(scene)
    assert second.blas_nodes is first.blas_nodes
    after = compress(second, before)
    assert after.blas_nodes is before.blas_nodes
    assert not np.array_equal(after.tlas_nodes, before.tlas_nodes)
    for ours, theirs in zip(after, compress(second), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_a_leaf_of_two_instances_is_not_lost_in_silence():
    packed = pack(SCENES["spheres"])
    nodes = packed.tlas_nodes.copy()
    nodes.view(dtype(NODE))["child"][0, 0] = ~2
    with pytest.raises(AssertionError, match="more than one instance"):
        compress(packed._replace(tlas_nodes=nodes))


@given(strategies.seeds, st.integers(1, 8))
def test_slots_are_given_at_the_least_cost(seed, count):
    """Against all ways to give children to slots, tried one after the other by swapping pairs and turning triples."""
    random = np.random.default_rng(seed)
    lo = random.uniform(-1, 1, (count, 3)).astype(np.float32)
    tree = compress_tree(node_of(lo, lo), np.zeros(1, np.int32))
    codes = compressed_children(tree.nodes).codes[0]
    offsets = np.zeros((8, 3))
    offsets[codes != EMPTY] = lo[tree.blocks] - (lo.min(0) + lo.max(0)) / 2.0
    corners = np.where(np.arange(8)[:, None] >> np.arange(3) & 1, 1, -1)
    gain = offsets @ corners.T  # of each child in each slot
    # A bipartite assignment is best when no cycle of moves gains: none of any length, by Bellman and Ford's argument.
    moves = gain - np.diag(gain)[:, None]
    for _ in range(8):
        moves = np.maximum(moves, (moves[:, :, None] + moves[None]).max(1))
    assert np.diag(moves).max() < 1e-4


# ---- rays ---------------------------------------------------------------------------------------------------------

def rays_through(points, random, count):
    """Return rays from around some points to some of them, or beside."""
    size = np.ptp(points, axis=0).max()
    away = linalg.normalize(random.normal(size=(count, 3))) * random.uniform(0, 2, (count, 1))
    origins = points.mean(0) + away * size
    beside = random.normal(size=(count, 3)) * random.choice([0, 0.01], (count, 1)) * size
    return origins, points[random.integers(len(points), size=count)] + beside - origins


@pytest.mark.parametrize("by_octant", [False, True])
@pytest.mark.parametrize("name", strategies.MESHES)
def test_rays_find_the_closest_triangle(name, by_octant):
    random = np.random.default_rng(1)
    corners = np.concatenate([strategies.MESHES[name](random) * random.uniform(0.1, 1) + random.uniform(-5, 5, 3)
                              for _ in range(60)])
    trees = compress(pack(Scene().add(strategies.mesh_of(corners))))
    assert trees.blas_depth > 1
    corners = corners.astype(np.float32).astype(np.float64)
    origins, directions = rays_through(corners.mean(1), random, 400)
    t = np.full(len(origins), np.inf)
    leaf = triangle_leaf(block_corners(trees.blas_blocks), origins, directions, t)
    walk(compressed_children(trees.blas_nodes), int(trees.roots[0]), origins, directions, t, leaf, by_octant)
    expected = triangle_hits(np.broadcast_to(corners, (len(origins), *corners.shape)), origins, directions).min(1)
    np.testing.assert_array_equal(t, expected)
    assert np.isfinite(t).mean() > 0.1


def scene_hits(children_of, packed, upper, lower, origins, directions):
    """Return t of the closest hits: down a scene's tree, into instances, down their trees.

    upper : (nodes, blocks of instances); lower : (nodes, blocks of triangles, root of each instance)
    """
    t, records = np.full(len(origins), np.inf), packed.instances.view(dtype(INSTANCE))
    below, corners = children_of(lower[0]), block_corners(lower[1])

    def enter(rays, blocks, counts):
        assert (counts == 1).all()
        instances = upper[1][blocks]
        for inst in np.unique(instances):
            some, record = rays[instances == inst], records[inst]
            if record["kind"] == SPHERE_KIND:
                t[some] = np.minimum(t[some], sphere_hits(record, origins[some], directions[some]))
                continue
            matrix = record["world_to_object"].reshape(3, 4).astype(np.float64)
            start, along = linalg.transform_points(matrix, origins[some]), linalg.transform_vectors(matrix,
                                                                                                   directions[some])
            here = t[some]
            walk(below, int(lower[2][inst]), start, along, here, triangle_leaf(corners, start, along, here))
            t[some] = here

    walk(children_of(upper[0]), 0, origins, directions, t, enter)
    return t


def sphere_hits(record, origins, directions):
    """Return t of rays that meet a sphere from outside."""
    to_center, squared = record["center"].astype(float) - origins, (directions**2).sum(1)
    along = (to_center * directions).sum(1)
    root = along**2 - squared * ((to_center**2).sum(1) - float(record["radius"])**2)
    t = (along - np.sqrt(np.maximum(root, 0))) / squared
    return np.where((root > 0) & (t > 0), t, np.inf)


@pytest.mark.parametrize("seed", range(3))
def test_rays_find_the_same_in_a_scene_of_many_things(seed):
    random = np.random.default_rng(seed)
    meshes = [strategies.mesh_of(strategies.MESHES[name](random)) for name in strategies.MESHES]
    scene, centers = Scene(), random.uniform(-20, 20, (60, 3))
    for k, center in enumerate(centers):
        turned = strategies.MATRICES[("turned", "mirrored", "stretched", "identity")[k % 4]](random)
        scene.add(Sphere(center, 0.5) if k % 5 == 0 else Instance(meshes[k % len(meshes)], linalg.compose(
            linalg.translation(center), turned)))
    packed, trees = check_scene(scene)
    origins, directions = rays_through(centers, random, 1500)
    first = packed.tlas_blocks.view(dtype(INSTANCE_BLOCK))["instance"][:, 0]
    before = scene_hits(wide_children, packed, (packed.tlas_nodes, first),
                        (packed.blas_nodes, packed.blas_blocks, packed.instances.view(dtype(INSTANCE))["root"]),
                        origins, directions)
    after = scene_hits(compressed_children, packed, (trees.tlas_nodes, trees.tlas_instances),
                       (trees.blas_nodes, trees.blas_blocks, trees.roots), origins, directions)
    np.testing.assert_allclose(after, before, rtol=1e-12)
    assert 0.1 < np.isfinite(after).mean() < 0.95
