"""Hits and shadows against brute force in float64 (see `oracle` for its tolerance and the reason for it)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import oracle
import strategies
import tracing
from glimt import linalg
from glimt.lanes import LANES
from glimt.layout import MISS
from glimt.packed import pack
from glimt.scene.instance import Instance
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere

STABLE = settings(derandomize=True, database=None, deadline=None, max_examples=200)
RAYS = 96


def assert_right(scene, origins, directions, t_max=1.0):
    """Hits and shadow rays are what the oracle allows; say which ray is not, if any."""
    packed = pack(scene)
    hits, found = tracing.closest(packed, origins, directions), oracle.meetings(scene, origins, directions)
    wrong = np.flatnonzero(oracle.wrong_hits(found, hits))
    expected = np.stack(oracle.closest(found), 1)
    assert not len(wrong), [(origins[i], directions[i], hits[i], expected[i]) for i in wrong[:3]]
    blocked = tracing.blocked(packed, origins, directions, t_max)
    wrong = np.flatnonzero(oracle.wrong_answers(found, blocked, t_max))
    assert not len(wrong), [(origins[i], directions[i], blocked[i], expected[i]) for i in wrong[:3]]


@STABLE
@given(scene=strategies.scenes(), kinds=strategies.ray_kinds, seed=strategies.seeds,
       t_max=st.sampled_from([0.5, 1.0, np.inf]))
def test_nasty_rays_through_nasty_scenes(scene, kinds, seed, t_max):
    assert_right(scene, *strategies.rays_for(scene, kinds, seed, RAYS), t_max)


@STABLE
@given(seed=strategies.seeds, matrix=st.sampled_from(["identity", "moved", "turned", "mirrored", "stretched"]))
def test_rays_in_general_position_need_no_excuse(seed, matrix):
    """Away from edges, the nearest primitive is the oracle's, and t, u and v agree to a few roundings."""
    random = np.random.default_rng(seed)
    scene = Scene().add(Sphere((1, 0, 0), 0.5), Sphere((-1, 0.5, 0), 0.25))
    scene.add(Instance(strategies.mesh_of(random.uniform(-1, 1, (12, 3, 3))), strategies.MATRICES[matrix](random)))
    origins, directions = strategies.rays_for(scene, ["outside", "surface"], seed, RAYS)
    directions += random.normal(size=directions.shape).astype(np.float32) * 0.1
    hits, found = tracing.closest(pack(scene), origins, directions), oracle.meetings(scene, origins, directions)
    clear = np.where(found.possible, found.sure & (found.spread < 1e-3), True).all(1)
    assert clear.mean() > 0.5
    t, inst, prim = (field[clear] for field in oracle.closest(found))
    hits = hits[clear]
    np.testing.assert_array_equal(hits.inst, inst)
    np.testing.assert_array_equal(hits.prim, prim)
    np.testing.assert_allclose(hits.t[inst != MISS], t[inst != MISS], rtol=1e-3)


# ---- a table of nasty cases, with answers that need no oracle ------------------------------------------------------

SQUARE = Mesh([(0, -1, 0), (2, -1, 0), (2, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
CASES = {
    "straight at it": ((0.25, 0.5, 3), (0, 0, -1), 3),
    "zeros of the other sign": ((0.25, 0.5, 3), (-0.0, -0.0, -1), 3),
    "mixed zeros": ((0.25, 0.5, -3), (0.0, -0.0, 1), 3),
    "on the shared edge": ((1.5, 0.5, 3), (0, 0, -1), 3),
    "on a corner": ((2, 1, 3), (0, 0, -1), 3),
    "along a side of the box": ((2, 0.5, 3), (0, 0, -1), 3),
    "along a side of the box that is 0": ((0, 0, 3), (0, 0, -1), 3),
    "along a side, from far": ((2, 0.5, 1e6), (0, 0, -1), 1e6),
    "from behind": ((0.25, 0.5, -3), (0, 0, 1), 3),
    "long direction": ((0.25, 0.5, 3), (0, 0, -1e12), 3e-12),
    "short direction": ((2, 0.5, 3), (0, 0, -1e-15), 3e15),
    "away from it": ((0.25, 0.5, 3), (0, 0, 1), np.inf),
    "beside it": ((2.001, 0.5, 3), (0, 0, -1), np.inf),
    "in its plane": ((-3, 0.25, 0), (1, 0, 0), np.inf),
    "in its plane, askew": ((-3, 0.25, 0), (1, 0.125, -0.0), np.inf),
    "starts on it": ((0.25, 0.5, 0), (0.5, 0.25, -1), np.inf),
}


@pytest.mark.parametrize("case", CASES)
def test_table_of_nasty_rays(case):
    origin, direction, t = CASES[case]
    hits = tracing.closest(pack(Scene().add(SQUARE)), [origin], [direction])
    assert hits.t[0] == pytest.approx(t, rel=1e-6)
    assert tracing.blocked(pack(Scene().add(SQUARE)), [origin], [direction])[0] == (t < np.inf)


@pytest.mark.parametrize("case", CASES)
def test_table_of_nasty_rays_in_a_mirrored_stretched_instance(case):
    """Powers of two and quarter turns lose no bit: the answer stays the same."""
    origin, direction, t = CASES[case]
    matrix = np.array([[0, -4, 0, 64], [-8, 0, 0, -32], [0, 0, 2, 16.0]])
    origin, direction = linalg.transform_points(matrix, origin), linalg.transform_vectors(matrix, direction)
    hits = tracing.closest(pack(Scene().add(Instance(SQUARE, matrix))), [origin], [direction])
    assert hits.t[0] == pytest.approx(t, rel=1e-6)


def test_ray_from_the_origin_along_a_side_of_the_box():
    """Where everything is 0, nothing is far enough from the side to be sure of it."""
    below = Mesh(-SQUARE.positions - np.float32([0, 0, 3]), SQUARE.triangles)
    assert tracing.closest(pack(Scene().add(below)), [(0, 0, 0)], [(0, 0, -1)]).t[0] == 3


@pytest.mark.parametrize(("origin", "direction", "t"), [
    ((0, 0, 3), (0, 0, -1), 2), ((0, 0, 3), (0, 0, -0.5), 4), ((0, 0, 0), (1, 0, 0), 1), ((0, 0, 0.5), (0, 0, 1), 0.5),
    ((3, 0, 0), (1, 0, 0), np.inf), ((3, 0.999, 0), (-1, 0, 0), 3 - 0.0447102), ((3, 1.001, 0), (-1, 0, 0), np.inf),
    ((1, 0, 0), (-1, 0, 0), 2), ((1, 0, 0), (1, 0, 0), np.inf), ((0, 1e4, 0), (0, -1, 0), 9999)])
def test_sphere(origin, direction, t):
    packed = pack(Scene().add(Sphere((0, 0, 0), 1)))
    assert tracing.closest(packed, [origin], [direction]).t[0] == pytest.approx(t, rel=1e-6)
    assert tracing.blocked(packed, [origin], [direction])[0] == (t < np.inf)


@pytest.mark.parametrize("corners", [[(0.1, 0.2, 0.3)] * 3, [(-1, 0.1, 0), (1, 0.7, 0), (1, 0.7, 0)]])
def test_triangle_with_repeated_corners_is_never_hit(corners):
    packed = pack(Scene().add(strategies.mesh_of([corners])))
    random = np.random.default_rng(0)
    origins = random.normal(size=(1000, 3))
    targets = np.einsum("nk,ka->na", random.dirichlet((1, 1, 1), 1000), np.array(corners, float))
    assert not tracing.closest(packed, origins, targets - origins).inst.max() >= 0
    assert not tracing.blocked(packed, origins, targets - origins).any()


def test_nothing_is_hit_in_an_empty_scene():
    hits = tracing.closest(pack(Scene()), [(0, 0, 0)], [(0, 0, 1)])
    assert hits.t[0] == np.inf
    assert hits.inst[0] == hits.prim[0] == MISS


def test_triangles_far_smaller_than_their_distance_from_a_ray_are_not_hit():
    """A packet's rays go where one of them must: the others must not take what they only pass by.

    Edge functions of a small triangle far away round to 0.
    """
    random = np.random.default_rng(1)
    scene = Scene().add(strategies.mesh_of(random.uniform(-1e-4, 1e-4, (64, 3, 3))))
    origins = random.normal(size=(200_000, 3)) * 1000
    directions = random.normal(size=origins.shape)
    towards = np.arange(len(origins)) % LANES == 0
    directions[towards] = random.uniform(-1e-4, 1e-4, (towards.sum(), 3)) - origins[towards]
    hits = tracing.closest(pack(scene), origins, directions)
    assert hits.inst[towards].max() == 0
    assert hits.inst[~towards].max() == MISS
