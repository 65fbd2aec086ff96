"""Embree as a yardstick holds the same scene: instances, spheres, ends of rays, packets that are not full."""

import numpy as np
import pytest

pytest.importorskip("embreex", reason="Embree, the yardstick, is not installed")

import closed_meshes
from glimt import Instance, Mesh, Scene, Sphere, linalg
from glimt.bench.embree import EmbreeScene
from glimt.bench.embree_rays import Tracers
from glimt.engines.cpu.closest_hits import closest_hits
from glimt.packed import pack

COUNT = 4001


def mixed_scene():
    """A mesh where it was modelled, two instances of another, one of them mirrored and stretched, and two spheres."""
    ball = closed_meshes.icosphere(2, roughness=0.05)
    turned = linalg.compose(linalg.translation((2.5, 0, 0)), linalg.rotation((1, 2, 0), 40),
                            linalg.scaling((-1, 0.5, 2)))
    raised = linalg.compose(linalg.translation((0, 2.5, 0)), linalg.scaling(0.7))
    return Scene().add(closed_meshes.icosphere(1), Instance(ball, turned), Instance(ball, raised),
                       Sphere((-2.5, 0, 0), 0.8), Sphere((0, -2, 0.5), 0.5))


@pytest.fixture(scope="module")
def answers():
    """Rays into that scene and glimt's distances, inf for none."""
    random = np.random.default_rng(3)
    origins, targets = random.uniform(-4, 4, (COUNT, 3)), random.uniform(-3, 3, (COUNT, 3))
    rays = np.concatenate([origins.T, (targets - origins).T, np.full((1, COUNT), np.inf)]).astype(np.float32)
    floats, ids = closest_hits(pack(mixed_scene()), rays)
    assert len(np.unique(ids[1])) == 6  # every object is seen, and so is nothing
    return rays[:6], np.where(ids[1] >= 0, floats[0], np.float32(np.inf))


@pytest.fixture(scope="module")
def tracers():
    return Tracers(EmbreeScene(mixed_scene()))


def ask(tracers, how, rays, ends, occlusion, shared_origin=False):
    rays = np.ascontiguousarray(np.concatenate([rays, ends[None]]), np.float32)
    t, prims = np.full(rays.shape[1] + 16, -7, np.float32), np.full(rays.shape[1] + 16, -7, np.int32)
    tracers.get(how, occlusion, shared_origin)(rays, t, prims, np.zeros(1, np.int64))
    assert (t[rays.shape[1]:] == -7).all()  # nothing is written past the last ray
    assert (prims[rays.shape[1]:] == -7).all()
    return t[:rays.shape[1]], prims[:rays.shape[1]]


def test_every_configuration_is_there(tracers):
    assert len({str(how) for how in tracers.configurations}) == len(tracers.configurations) == 12
    alone = Tracers(EmbreeScene(Scene().add(closed_meshes.icosphere(1))))
    assert {how.flat for how in alone.configurations} == {False}


@pytest.mark.parametrize("count", [COUNT - 5, 16, 3])
def test_closest_hits_are_ours(tracers, answers, count):
    rays, expected = answers[0][:, :count], answers[1][:count]
    for how in tracers.configurations:
        t, prims = ask(tracers, how, rays, np.full(count, np.inf), False)
        np.testing.assert_array_equal(np.isinf(t), np.isinf(expected), err_msg=str(how))
        np.testing.assert_array_equal(prims < 0, np.isinf(expected), err_msg=str(how))
        met = np.isfinite(expected)
        np.testing.assert_allclose(t[met], expected[met], rtol=1e-4, err_msg=str(how))


def test_occlusion_ends_where_the_ray_does(tracers, answers):
    rays, expected = answers
    ends = np.random.default_rng(4).uniform(0, 1.2, COUNT).astype(np.float32)
    assert 0.1 < (expected < ends).mean() < 0.9
    for how in tracers.configurations:
        t, _ = ask(tracers, how, rays, ends, True)
        clear = np.abs(expected - ends) > 1e-4
        np.testing.assert_array_equal((t < 0)[clear], (expected < ends)[clear], err_msg=str(how))


def test_an_origin_that_all_share_is_that_of_the_first(tracers, answers):
    given, ends = answers[0], np.full(COUNT, np.inf, np.float32)
    rays = np.concatenate([given[:3, :1].repeat(COUNT, 1), given[:3] + given[3:] - given[:3, :1]])
    others = rays.copy()
    others[:3, 1:] = 100
    for how in tracers.configurations:
        for occlusion in (False, True):
            t, prims = ask(tracers, how, rays, ends, occlusion)
            assert 0.1 < (t < (0 if occlusion else np.inf)).mean() < 0.9
            np.testing.assert_array_equal(ask(tracers, how, others, ends, occlusion, True), (t, prims), str(how))


def test_a_mesh_without_triangles_is_left_out():
    empty = Mesh(np.zeros((3, 3), np.float32), np.zeros((0, 3), np.int32))
    tracers = Tracers(EmbreeScene(Scene().add(empty, Sphere((0, 0, 0), 1.0))))
    rays = np.array([[0, 0, 5, 0, 0, -1]], np.float32).T
    for how in tracers.configurations:
        assert ask(tracers, how, rays, np.array([np.inf]), False)[0] == pytest.approx(4, rel=1e-5)
