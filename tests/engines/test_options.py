"""The ways an engine can go about a picture: the same bits, and times that add up."""

from dataclasses import replace

import numpy as np
import pytest

import closed_meshes
import glimt
from glimt import linalg
from glimt.engines import EngineOptions
from glimt.errors import GlimtError
from glimt.layout import STAGES
from glimt.renderer import Renderer


def scene_of_all_kinds():
    """Return placed, flat and shared meshes, spheres, two lights and mirrors, in a picture with odd sides."""
    gold = glimt.Material(diffuse=(0.6, 0.4, 0.1), specular=0.5, reflectivity=0.4)
    ball = closed_meshes.icosphere(2)
    scene = glimt.Scene(settings=glimt.RenderSettings(93, 61, 2, 3, background=0.2, ambient=0.1))
    scene.add(glimt.Mesh([[-3, -1, -3], [3, -1, -3], [3, -1, 3], [-3, -1, 3]], [[0, 2, 1], [0, 3, 2]]))
    for x in (-1.5, 0.0, 1.5):
        place = linalg.compose(linalg.translation((x, -0.4, x / 3)), linalg.rotation((1, 2, 3), 40 * x),
                               linalg.scaling((0.6, 0.4, 0.5)))
        scene.add(glimt.Instance(ball, place, gold))
    scene.add(glimt.Sphere((0, 0.5, -1), 0.6, gold), glimt.Sphere((2, 0, -2), 1.0))
    scene.add(glimt.PointLight(position=(1, 4, 2), radius=6), glimt.DirectionalLight(direction=(1, -2, -0.5)))
    scene.camera = glimt.Camera((0.5, 1, 4), (0, 0, 0), fov_deg=50)
    return scene


@pytest.fixture(scope="module")
def scene():
    return scene_of_all_kinds()


@pytest.fixture(scope="module")
def usual(scene):
    return Renderer(scene, engine="cpu").render()


WAYS = [EngineOptions(tile=8), EngineOptions(tile=48), EngineOptions(tile=1024), EngineOptions(packets=1),
        EngineOptions(packets=2, tile=24), EngineOptions(brute_force=True),
        EngineOptions(brute_force=True, packets=1), EngineOptions(time_stages=True)]


@pytest.mark.parametrize("options", WAYS, ids=lambda way: ",".join(map(str, way)))
@pytest.mark.parametrize("threads", [1, 3])
def test_the_same_film_and_the_same_rays_whatever_the_way(scene, usual, options, threads):
    film = Renderer(scene, engine="cpu", threads=threads, options=options).render()
    np.testing.assert_array_equal(film.sums, usual.sums)
    assert film.counters == usual.counters


def test_brute_force_knows_a_mesh_again_that_stands_second(usual, scene):
    """Spans count from the start of all meshes, and an instance may use any of them."""
    turned = replace(scene, objects=scene.objects[::-1])
    film = Renderer(turned, engine="cpu", options=EngineOptions(brute_force=True)).render()
    np.testing.assert_array_equal(film.sums, Renderer(turned, engine="cpu").render().sums)


def test_brute_force_follows_changes_and_leaves_out_empty_meshes(scene):
    changed = replace(scene, objects=[glimt.Instance(glimt.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))),
                                      *scene.objects])
    renderer = Renderer(changed, engine="cpu", options=EngineOptions(brute_force=True))
    renderer.render()
    changed.objects = changed.objects[:3]
    renderer.update()
    np.testing.assert_array_equal(renderer.render().sums, Renderer(changed, engine="cpu").render().sums)


def test_brute_force_of_nothing_is_the_background():
    empty = glimt.Scene(settings=glimt.RenderSettings(16, 16, background=0.25),
                        camera=glimt.Camera((0, 0, 1), (0, 0, 0)))
    film = Renderer(empty, engine="cpu", options=EngineOptions(brute_force=True)).render()
    assert (film.radiance == 0.25).all()


def test_rays_from_arrays_test_everything_too(scene):
    usual, forced = (Renderer(scene, engine="cpu", options=EngineOptions(brute_force=way)) for way in (False, True))
    assert usual.pick(46.5, 30.5) == forced.pick(46.5, 30.5)
    assert usual.pick(46.5, 30.5) is not None


@pytest.mark.parametrize("threads", [1, 2])
def test_stages_fill_a_frame_in_their_order(scene, threads):
    renderer = Renderer(scene, engine="cpu", threads=threads, options=EngineOptions(time_stages=True))
    film = renderer.render()
    assert tuple(film.stages) == STAGES
    assert sum(film.stages.values()) == pytest.approx(film.seconds)
    assert min(film.stages.values()) > 0


def test_stages_follow_the_work(scene):
    """Fifteen lights are much more to shade by than two."""
    def shading(lights):
        settings = replace(scene.settings, max_bounces=0)
        renderer = Renderer(replace(scene, settings=settings, lights=lights), engine="cpu", threads=1,
                            options=EngineOptions(time_stages=True))
        return min(renderer.render().stages["shade"] for _ in range(8))  # the least: others may use the machine

    assert shading([scene.lights[0]] * 15) > 1.5 * shading(scene.lights)


def test_stages_are_not_timed_unless_asked_for(usual):
    assert usual.stages == {}


@pytest.mark.parametrize("options", [EngineOptions(tile=12), EngineOptions(tile=0), EngineOptions(tile=2048),
                                     EngineOptions(packets=3), EngineOptions(packets=0)])
def test_what_cannot_be_is_refused(scene, options):
    with pytest.raises(GlimtError, match="expected a multiple of 8 up to 1024, and one of 1, 2, 4"):
        Renderer(scene, engine="cpu", options=options)
