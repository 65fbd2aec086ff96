"""A plane under directional and point lights: diffuse and ambient light, in closed form."""

import numpy as np
import pytest
from pictures import direction, facing, picture, pixel, plane

from glimt import Camera, DirectionalLight, Material, PointLight, Sphere

KD = np.array([0.2, 0.5, 0.9])
LIGHT = np.array([1.0, 2.0, 0.25])
NO_FALLOFF = (1, 0, 0)


@pytest.mark.parametrize("tilt", [0, 10, 45, 60, 80, 89])
@pytest.mark.parametrize("around", [0, 135])
def test_directional_light_is_lambert(tilt, around):
    light = DirectionalLight(direction=-3 * direction(tilt, around), diffuse=LIGHT)
    seen = pixel(plane(Material(diffuse=KD)), light, camera=facing(x=0.3, y=-0.2))
    np.testing.assert_allclose(seen, KD * LIGHT * np.cos(np.radians(tilt)), rtol=1e-5)


@pytest.mark.parametrize("tilt", [0, 10, 45, 60, 80, 89])
@pytest.mark.parametrize("distance", [0.5, 2.0, 700.0])
def test_point_light_is_lambert(tilt, distance):
    place = np.array([0.3, -0.2, 0]) + distance * direction(tilt, 77)
    light = PointLight(position=place, diffuse=LIGHT, attenuation=NO_FALLOFF)
    seen = pixel(plane(Material(diffuse=KD)), light, camera=facing(x=0.3, y=-0.2))
    np.testing.assert_allclose(seen, KD * LIGHT * np.cos(np.radians(tilt)), rtol=1e-5)


def test_viewer_and_angle_of_view_do_not_matter_to_diffuse_light():
    light = DirectionalLight(direction=(0.2, 0.1, -1))
    seen = [pixel(plane(), light, camera=Camera(position, (0, 0, 0), (0, 1, 0)))
            for position in ((0, 0, 3), (2, 0, 1), (-4, 1, 0.2))]
    np.testing.assert_allclose(seen, np.full((3, 3), seen[0][0]), rtol=1e-6)


@pytest.mark.parametrize("smooth", [False, True])
def test_both_sides_are_lit(smooth):
    square = plane(Material(diffuse=KD), smooth=smooth)
    behind = Camera((0.3, 0.2, -3), (0.3, 0.2, 0))
    tilted = -direction(30) * [1, 1, -1]  # travels towards +Z
    np.testing.assert_allclose(pixel(square, DirectionalLight(direction=tilted), camera=behind),
                               KD * np.cos(np.radians(30)), rtol=1e-5)


@pytest.mark.parametrize("smooth", [False, True])
def test_light_from_behind_does_not_shine_through(smooth):
    square = plane(Material(specular=1), smooth=smooth)
    for light in (DirectionalLight(direction=(0, 0.1, 1)), PointLight(position=(0, 0, -1))):
        assert not pixel(square, light, camera=facing()).any()
    for light in (DirectionalLight(direction=(0, 0.1, -1)), PointLight(position=(0, 0, 1))):
        assert not pixel(square, light, camera=Camera((0, 0, -3), (0, 0, 0))).any()


def test_lights_add_up():
    lights = [DirectionalLight(direction=-direction(20), diffuse=(1, 0, 0.5)),
              DirectionalLight(direction=-direction(50, 90), diffuse=(0.1, 3, 0)),
              DirectionalLight(direction=direction(50, 90), diffuse=5),  # from behind
              PointLight(position=(0, 0, 2), diffuse=(0, 0, 2))]
    square = plane(Material(diffuse=KD))
    alone = [pixel(square, light, camera=facing()) for light in lights]
    together = pixel(square, *lights, camera=facing())
    np.testing.assert_allclose(together, np.sum(alone, 0), rtol=1e-6)
    expected = KD * (np.cos(np.radians(20)) * np.array([1, 0, 0.5]) + np.cos(np.radians(50)) * np.array([0.1, 3, 0])
                     + np.array([0, 0, 2]) / (1 + 2**2))
    np.testing.assert_allclose(together, expected, rtol=2e-5)


def test_ambient_light_of_scene_and_lights_arrives_everywhere():
    ka = np.array([0.5, 0.25, 0.125])
    square = plane(Material(ambient=ka, diffuse=0))
    lights = [DirectionalLight(direction=(0, 0, -1), ambient=(0.1, 0.2, 0.3), diffuse=0),
              PointLight(position=(0, 0, -9), ambient=0.05)]
    for camera in (facing(), Camera((0, 0, -3), (0, 0, 0))):
        seen = pixel(square, *lights, Sphere((0, 0, 50), 40), camera=camera, ambient=(0.01, 0.02, 0.04))
        np.testing.assert_allclose(seen, ka * [0.16, 0.27, 0.39], rtol=1e-6)


def test_ambient_reflectance_is_the_diffuse_one_unless_given():
    np.testing.assert_allclose(pixel(plane(Material(diffuse=KD)), camera=facing(), ambient=LIGHT), KD * LIGHT,
                               rtol=1e-6)
    assert not pixel(plane(Material(diffuse=KD, ambient=0)), camera=facing(), ambient=LIGHT).any()


def test_rays_that_miss_see_the_background():
    seen = picture(plane(), camera=facing(half=2.0), size=(16, 16), background=(0.1, 0.2, 0.3), ambient=1)
    np.testing.assert_array_equal(seen[:4], np.broadcast_to(np.float32([0.1, 0.2, 0.3]), (4, 16, 3)))
    np.testing.assert_allclose(seen[4:12, 4:12], 0.8, rtol=1e-6)
    np.testing.assert_array_equal(seen[12:, :, 2], np.float32(0.3))


def test_nothing_behind_the_camera_is_seen():
    assert pixel(plane(), Sphere((0, 0, 9), 1), camera=Camera((0, 0, 3), (0, 0, 6)), ambient=1,
                 background=7).tolist() == pytest.approx([0.8] * 3)
    assert pixel(plane(), camera=Camera((0, 0, 3), (0, 0, 6)), ambient=1, background=7).tolist() == [7, 7, 7]
