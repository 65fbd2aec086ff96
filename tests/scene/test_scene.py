"""The scene as a plain object."""

import numpy as np
import pytest

from glimt import Camera, DirectionalLight, Instance, Mesh, PointLight, RenderSettings, Scene, Sphere, linalg

MESH = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="flag")


def test_add_sorts_things_and_returns_the_scene():
    scene, light, ball = Scene(), PointLight(position=(0, 0, 0)), Sphere((0, 0, 0), 1)
    placed = Instance(MESH, linalg.translation((1, 0, 0)))
    assert scene.add(MESH, ball, light).add(placed) is scene
    assert scene.lights == [light]
    assert scene.spheres() == [ball]
    assert scene.instances()[1] is placed
    assert scene.instances()[0].mesh is MESH
    assert scene.instances()[0].name == "flag"
    assert scene.objects == [scene.instances()[0], ball, placed]


def test_scenes_share_nothing():
    Scene().add(MESH, DirectionalLight(direction=(0, 0, 1)))
    assert Scene().objects == Scene().lights == []


def test_bounds_of_everything_that_is_drawn():
    scene = Scene().add(Instance(MESH, linalg.compose(linalg.translation((0, 0, 7)), linalg.scaling((1, 2, 3)))),
                        Sphere((-5, 0, 0), 0.5), Mesh([[99, 99, 99]], np.zeros((0, 3))))
    lo, hi = scene.bounds()
    np.testing.assert_allclose(lo, [-5.5, -0.5, -0.5])
    np.testing.assert_allclose(hi, [1, 2, 7])
    np.testing.assert_array_equal(Scene().bounds(), [[-1] * 3, [1] * 3])


def test_the_camera_given_or_one_that_frames_all():
    camera = Camera((1, 2, 3))
    assert Scene(camera=camera).camera_or_framing() is camera
    framing = Scene().add(Sphere((10, 0, 0), 2)).camera_or_framing()
    assert framing.target == (10, 0, 0)
    wide = Scene(settings=RenderSettings(100, 400)).add(Sphere((10, 0, 0), 2)).camera_or_framing()
    assert np.linalg.norm(np.subtract(wide.position, wide.target)) > np.linalg.norm(
        np.subtract(framing.position, framing.target))


@pytest.mark.parametrize("value", [4, 4.0, "4", np.int64(4), np.float32(4)])
def test_whole_numbers_of_settings(value):
    settings = RenderSettings(value, value, value, value)
    assert (settings.width, settings.height, settings.samples, settings.max_bounces) == (4, 4, 4, 4)
    assert type(settings.width) is int


def test_settings_default_to_a_plain_picture():
    settings = RenderSettings()
    assert (settings.samples, settings.max_bounces, settings.background, settings.tone_curve) == (
        1, 0, (0, 0, 0), "clamp")
