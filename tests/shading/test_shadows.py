"""Who stands in whose light: shadow boundaries from closed forms, and no shadow where there is none."""

import numpy as np
import pytest
from pictures import direction, facing, picture, pixel, plane, plane_points, ray_directions, sphere_distance, unit

from glimt import Camera, DirectionalLight, Instance, Material, PointLight, Sphere, linalg

SIZE = (65, 65)
FLOOR = plane(Material(diffuse=1), half=4)
BLACK = Material(diffuse=0)
SUN = DirectionalLight(direction=(2, -1, -2))
LAMP = PointLight(position=(-3.0, 1.0, 4.0), attenuation=(1, 0, 0))


def _way_to(light, points):
    """Return unit directions from points to a light and the distances."""
    if isinstance(light, DirectionalLight):
        way = np.broadcast_to(-unit(light.direction), points.shape)
        return way, np.full(points.shape[:-1], np.inf)
    way = np.asarray(light.position) - points
    return unit(way), np.linalg.norm(way, axis=-1)


def _check(seen, lit, shadowed, expected):
    """Compare a picture with masks that leave out the pixels next to a boundary."""
    assert lit.sum() > 100
    assert shadowed.sum() > 100
    assert lit.sum() + shadowed.sum() > 0.8 * lit.size
    assert not seen[shadowed].any()
    np.testing.assert_allclose(seen[lit], expected[lit], rtol=2e-5)


@pytest.mark.parametrize("light", [SUN, LAMP])
def test_shadow_of_a_sphere(light):
    center, radius = np.array([-1.0, 0.5, 1.5]), 0.9
    camera = facing(30, 2.5)
    seen = picture(FLOOR, Sphere(center, radius, BLACK), light, camera=camera, size=SIZE)[..., 0]
    points = plane_points(camera, *SIZE)
    floor_seen = np.isnan(sphere_distance(camera.position, ray_directions(camera, *SIZE), center, radius * 1.001))
    way, _ = _way_to(light, points)
    beside = np.linalg.norm(np.cross(center - points, way), axis=-1)
    _check(seen, floor_seen & (beside > radius + 1e-4), floor_seen & (beside < radius - 1e-4), way[..., 2])


@pytest.mark.parametrize("light", [SUN, LAMP])
@pytest.mark.parametrize("turned", [0, 30])
def test_shadow_of_a_square(light, turned):
    height, half = 1.25, 0.8
    matrix = linalg.compose(linalg.translation((-0.7, 0.6, height)), linalg.rotation((0, 0, 1), turned))
    square = Instance(plane(BLACK, half=half), matrix)
    camera = Camera((0, 0, -30), (0, 0, 0), (0, 1, 0), 10.0)  # from below a floor that lets nothing through
    above = facing(30, 2.5)
    points = plane_points(above, *SIZE)
    way, distance = _way_to(light, points)
    assert (distance > height).all()
    met = linalg.transform_points(linalg.inverse(matrix), points + way * (height / way[..., 2:]))
    beyond = np.abs(met[..., :2]).max(-1)
    looked_through = linalg.transform_points(linalg.inverse(matrix), points + (np.array(above.position) - points)
                                             * (height / above.position[2]))
    floor_seen = np.abs(looked_through[..., :2]).max(-1) > half + 1e-4
    seen = picture(FLOOR, square, light, camera=above, size=SIZE)[..., 0]
    _check(seen, floor_seen & (beyond > half + 1e-4), floor_seen & (beyond < half - 1e-4), way[..., 2])
    assert not picture(FLOOR, square, light, camera=camera, size=(9, 9)).any()


def test_what_stands_behind_a_light_casts_no_shadow():
    light = PointLight(position=(0, 0, 1), attenuation=(1, 0, 0))
    alone = pixel(FLOOR, light, camera=facing(0.5))
    assert alone == pytest.approx(1, rel=1e-5)
    for z in (1.001, 2.0, 50.0):
        lid = Instance(plane(BLACK), linalg.translation((0, 0, z)))
        np.testing.assert_array_equal(pixel(FLOOR, lid, light, camera=facing(0.5)), alone)
    lid = Instance(plane(BLACK), linalg.translation((0, 0, 0.999)))
    assert not pixel(FLOOR, lid, light, camera=facing(0.5)).any()


@pytest.mark.parametrize("height", [1.0, 1.1, 2.7])
@pytest.mark.parametrize("shift", [0, 1 / 3, 7.7])
def test_a_lamp_in_a_ceiling_lights_the_room(height, shift):
    """The ceiling is neither in front of the lamp nor behind it: without a rule it would shadow some pixels."""
    matrix = linalg.compose(linalg.translation((shift, 0, height)), linalg.rotation((0, 0, 1), 20))
    lamp = PointLight(position=(0.2, 0.1, height), attenuation=(1, 0, 0))
    camera = Camera((0, 0, height / 2), (0, 0, 0), fov_deg=90)
    seen = picture(plane(Material(diffuse=1), half=9), Instance(plane(half=9), matrix), lamp, camera=camera, size=SIZE)
    assert seen.min() > 0.3


def test_lights_have_a_shadow_each():
    ball = Sphere((-1, 0.5, 1.5), 0.9, BLACK)
    camera = facing(30, 2.5)
    lights = [SUN, LAMP, DirectionalLight(direction=(-1, 0, -1))]
    alone = [picture(FLOOR, ball, light, camera=camera, size=SIZE) for light in lights]
    together = picture(FLOOR, ball, *lights, camera=camera, size=SIZE)
    np.testing.assert_allclose(together, np.sum(alone, 0), rtol=1e-6)
    in_shadow = [shadow[..., 0] == 0 for shadow in alone]
    assert len({shadow.tobytes() for shadow in in_shadow}) == 3
    assert all(shadow.any() for shadow in in_shadow)


@pytest.mark.parametrize("scale", [2.0**-10, 1.0, 2.0**17])
@pytest.mark.parametrize("light", [DirectionalLight(direction=(-1, -2, -3)),
                                   PointLight(position=(2, 4, 6), attenuation=(1, 0, 0))])
def test_a_sphere_does_not_shadow_its_lit_side(light, scale):
    if isinstance(light, PointLight):
        light = PointLight(position=np.multiply(light.position, scale), attenuation=(1, 0, 0))
    camera = Camera((0, 0, 5 * scale), (0, 0, 0), fov_deg=20)
    seen = picture(Sphere((0, 0, 0), scale, Material(diffuse=1)), light, camera=camera, size=SIZE)[..., 0]
    directions = ray_directions(camera, *SIZE)
    t = sphere_distance(camera.position, directions, (0, 0, 0), scale)
    points = camera.position + directions * t[..., None]
    way, _ = _way_to(light, np.nan_to_num(points))
    cosine = (points / scale * way).sum(-1)
    np.testing.assert_allclose(seen[cosine > 0.01], cosine[cosine > 0.01], rtol=1e-4, atol=2e-5)
    assert not seen[cosine < -1e-4].any()
    assert (cosine > 0.01).sum() > 1000


def test_a_sphere_is_lit_from_inside():
    camera = Camera((0.2, 0, 0), (1, 0.3, 0.2), fov_deg=120)
    light = PointLight(position=(-0.3, 0.1, 0.2), attenuation=(1, 0, 0))
    seen = picture(Sphere((0, 0, 0), 2, Material(diffuse=1)), light, camera=camera, size=(33, 33))[..., 0]
    directions = ray_directions(camera, 33, 33)
    points = camera.position + directions * sphere_distance(camera.position, directions, (0, 0, 0), 2)[..., None]
    way, _ = _way_to(light, points)
    np.testing.assert_allclose(seen, -(points / 2 * way).sum(-1), rtol=1e-5)


@pytest.mark.parametrize("exponent", [-12, 9, 17])
def test_scenes_of_any_size_look_the_same(exponent):
    """Nothing is compared with an absolute length: a power of two changes no bit of the picture."""
    def seen(scale):
        things = [Instance(plane(Material(diffuse=0.5, specular=0.5, reflectivity=0.3), half=4),
                           linalg.scaling(scale)),
                  Instance(plane(half=0.7), linalg.compose(linalg.translation((0.5 * scale, 1 * scale, scale)),
                                                           linalg.rotation((1, 2, 0), 40), linalg.scaling(scale))),
                  Sphere((-scale, 0, scale), 0.75 * scale, Material(diffuse=0.2, reflectivity=0.5)),
                  PointLight(position=(scale, -scale, 3 * scale), radius=scale),
                  DirectionalLight(direction=-direction(40, 100))]
        camera = Camera((3 * scale, -5 * scale, 4 * scale), (0, 0, 0.5 * scale), (0, 0, 1))
        return picture(*things, camera=camera, size=(48, 48), max_bounces=2, background=0.1)

    np.testing.assert_array_equal(seen(2.0**exponent), seen(1.0))
